#include "calib/develop.h"

#include <opencv2/core/cvdef.h>

#include "calib/demosaic.h"

namespace lamella {

namespace {

// Of a gain that was computed to make full scale the saturation.
constexpr double kRounding = 1e-9;

// `value` or, where that would round below `floor`, the next half above it.
float half_not_below(double floor, double value) {
  const float rounded = float(cv::float16_t(float(value)));
  return double(rounded) >= floor ? float(value) : float(value) * (1 + 1.f / 1024);
}

Raw12Table stored_values(const RawFormat& format) {
  Raw12Table table;
  for (int dn = 0; dn < kRaw12Levels; ++dn) {
    const double stored = (dn - format.black_level_dn) * format.gain_per_dn;
    const bool clipped = stored >= format.saturation * (1 - kRounding) || dn == kRaw12Levels - 1;
    const bool known = format.saturation < 1e29;
    table[size_t(dn)] = clipped && known
                            ? half_not_below(format.saturation, std::max(stored, format.saturation))
                            : float(stored);
  }
  return table;
}

}  // namespace

Image3 develop(const std::vector<uint8_t>& bytes, cv::Size size, const RawFormat& format) {
  const Raw12Table table = stored_values(format);
  if (format.pixels == RawPixels::kRgb) return map_rgb12p(bytes.data(), bytes.size(), size, table);
  if (is_mosaic(format.pixels) && (size.width < 2 || size.height < 2)) return {};
  const Image1 plane = map_plane12p(bytes.data(), bytes.size(), size, table);
  if (plane.empty()) return {};
  if (is_mosaic(format.pixels)) return demosaic(plane, format.pixels, float(format.saturation));
  Image3 image;
  cv::merge(std::vector<Image1>(3, plane), image);
  return image;
}

}  // namespace lamella
