#include "io/raw12.h"

#include <algorithm>
#include <map>

#include "base/parallel.h"

namespace lamella {

namespace {

constexpr size_t kPairsPerBlock = 1 << 14;

uint16_t first_of(const uint8_t* p) { return uint16_t(p[0] | (p[1] & 0x0f) << 8); }
uint16_t second_of(const uint8_t* p) { return uint16_t(p[1] >> 4 | p[2] << 4); }

// to[i] = value(i-th sample) for all samples, in parallel blocks of whole pairs.
template <class Sample, class Value>
void unpack(const uint8_t* bytes, size_t samples, Sample* to, const Value& value) {
  const size_t pairs = samples / 2;
  const int blocks = int((pairs + kPairsPerBlock - 1) / kPairsPerBlock);
  parallel_for(blocks, [&](int block) {
    const size_t from = size_t(block) * kPairsPerBlock;
    for (size_t i = from; i < std::min(pairs, from + kPairsPerBlock); ++i) {
      to[2 * i] = value(first_of(bytes + 3 * i));
      to[2 * i + 1] = value(second_of(bytes + 3 * i));
    }
  });
  if (samples % 2) to[samples - 1] = value(first_of(bytes + 3 * pairs));
}

template <class Image, class Value>
Image unpacked(const uint8_t* bytes, size_t size_bytes, cv::Size size, const Value& value) {
  if (size.width <= 0 || size.height <= 0) return {};
  if (size_bytes != rgb12p_bytes(size_t(size.width), size_t(size.height))) return {};
  Image image(size);
  unpack(bytes, image.total() * 3, image[0][0].val, value);
  return image;
}

}  // namespace

std::optional<RawPixels> raw_pixels_named(const std::string& pixel_format) {
  static const std::map<std::string, RawPixels> kNames = {
      {kRgb12p, RawPixels::kRgb},    {"GREY12P", RawPixels::kGrey}, {"RGGB12P", RawPixels::kRggb},
      {"GRBG12P", RawPixels::kGrbg}, {"GBRG12P", RawPixels::kGbrg}, {"BGGR12P", RawPixels::kBggr}};
  const auto found = kNames.find(pixel_format);
  if (found == kNames.end()) return std::nullopt;
  return found->second;
}

size_t raw12_bytes(RawPixels pixels, size_t width, size_t height) {
  if (is_mosaic(pixels) && (width < 2 || height < 2)) return 0;
  if (pixels == RawPixels::kRgb) return rgb12p_bytes(width, height);
  return (width * height + 1) / 2 * 3;
}

std::vector<uint8_t> pack_rgb12p(const RawImage& raw_dn) {
  const RawImage dn = raw_dn.isContinuous() ? raw_dn : RawImage(raw_dn.clone());
  const size_t samples = dn.total() * 3;
  std::vector<uint8_t> bytes(rgb12p_bytes(size_t(dn.cols), size_t(dn.rows)));
  const uint16_t* from = dn.empty() ? nullptr : dn[0][0].val;
  for (size_t i = 0; i < samples; i += 2) {
    const uint16_t a = from[i] & 0xfff, b = i + 1 < samples ? from[i + 1] & 0xfff : 0;
    uint8_t* to = &bytes[i / 2 * 3];
    to[0] = uint8_t(a);
    to[1] = uint8_t(a >> 8 | (b & 0x0f) << 4);
    to[2] = uint8_t(b >> 4);
  }
  return bytes;
}

RawImage unpack_rgb12p(const uint8_t* bytes, size_t size_bytes, cv::Size size) {
  return unpacked<RawImage>(bytes, size_bytes, size, [](uint16_t dn) { return dn; });
}

Image3 map_rgb12p(const uint8_t* bytes, size_t size_bytes, cv::Size size, const Raw12Table& table) {
  return unpacked<Image3>(bytes, size_bytes, size, [&](uint16_t dn) { return table[dn]; });
}

Image1 map_plane12p(const uint8_t* bytes, size_t size_bytes, cv::Size size,
                    const Raw12Table& table) {
  if (size.width <= 0 || size.height <= 0) return {};
  if (size_bytes != raw12_bytes(RawPixels::kGrey, size_t(size.width), size_t(size.height))) {
    return {};
  }
  Image1 plane(size);
  unpack(bytes, plane.total(), plane[0], [&](uint16_t dn) { return table[dn]; });
  return plane;
}

}  // namespace lamella
