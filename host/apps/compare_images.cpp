#include "apps/compare_images.h"

#include <algorithm>

#include "base/error.h"
#include "io/picture_png.h"
#include "io/whole_file.h"

namespace lamella::apps {

namespace {

constexpr double kBestPsnrDb = 120;

double srgb(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  return x < 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
}

// The values of the masked pixels, r g b in turn.
std::vector<double> masked_values(const Image3& image, const Mask& mask) {
  std::vector<double> values;
  for (int i = 0; i < image.rows; ++i) {
    for (int j = 0; j < image.cols; ++j) {
      if (!mask.empty() && !mask(i, j)) continue;
      for (int c = 0; c < 3; ++c) values.push_back(image(i, j)[c]);
    }
  }
  return values;
}

std::vector<double> zero_where_not_finite(std::vector<double> values) {
  for (double& v : values) v = std::isfinite(v) ? v : 0;
  return values;
}

struct Sums {
  double error = 0, found = 0, truth = 0, both = 0;
};

Sums sums_of(const std::vector<double>& found, const std::vector<double>& truth) {
  Sums s;
  for (size_t i = 0; i < found.size(); ++i) {
    s.error += (found[i] - truth[i]) * (found[i] - truth[i]);
    s.found += found[i] * found[i];
    s.truth += truth[i] * truth[i];
    s.both += found[i] * truth[i];
  }
  return s;
}

double psnr_db(const std::vector<double>& found, const std::vector<double>& truth) {
  const double white = percentile(truth, 0.99);
  double squares = 0;
  for (size_t i = 0; i < found.size(); ++i) {
    const double d = srgb(found[i] / white) - srgb(truth[i] / white);
    squares += d * d;
  }
  return std::min(-10 * std::log10(std::max(squares / double(found.size()), 1e-12)), kBestPsnrDb);
}

// Share of pixels (three values each) for which `is` holds.
template <class Is>
double share_of_pixels(const std::vector<double>& values, const Is& is) {
  size_t count = 0;
  for (size_t i = 0; i < values.size(); i += 3) count += is(&values[i]);
  return double(count) / (double(values.size()) / 3);
}

}  // namespace

Json image_figures(const Image3& found_image, const Image3& truth_image, const Mask& mask) {
  const std::vector<double> raw = masked_values(found_image, mask);
  const std::vector<double> found = zero_where_not_finite(raw);
  const std::vector<double> truth = masked_values(truth_image, mask);
  const Sums s = sums_of(found, truth);
  const double scale = s.both / std::max(s.found, 1e-30);
  const double scaled = scale * scale * s.found - 2 * scale * s.both + s.truth;
  Json ratio = Json::array();
  for (int c = 0; c < 3; ++c) {
    double a = 0, b = 0;
    for (size_t i = size_t(c); i < found.size(); i += 3) a += found[i], b += truth[i];
    ratio.push_back(number(a / b));
  }
  return {{"rel_rmse", number(std::sqrt(s.error / s.truth))},
          {"rel_rmse_best_scale", number(std::sqrt(std::max(0.0, scaled) / s.truth))},
          {"best_scale", number(scale)},
          {"psnr_srgb_db", number(psnr_db(found, truth))},
          {"mean_ratio_rgb", ratio},
          {"nonfinite", share_of_pixels(raw,
                                        [](const double* p) {
                                          return !(std::isfinite(p[0]) && std::isfinite(p[1]) &&
                                                   std::isfinite(p[2]));
                                        })},
          {"black", share_of_pixels(found, [](const double* p) {
             return std::max({p[0], p[1], p[2]}) <= 0;
           })}};
}

double relative_rmse(const Image3& found, const Image3& truth, const Mask& mask) {
  const Sums s =
      sums_of(zero_where_not_finite(masked_values(found, mask)), masked_values(truth, mask));
  return std::sqrt(s.error / s.truth);
}

Mask read_mask(const fs::path& file, const cv::Size& size) {
  const std::string bytes = read_text(file);
  const cv::Size found = png_header(bytes, file.string()).size;
  if (found != size) {
    throw_bad_input(file.string(), "is " + size_words(found) + ", the image " + size_words(size),
                    "give a mask of the image's size");
  }
  Mask is_zero;
  cv::inRange(decode_png(bytes, file.string()), cv::Scalar::all(0), cv::Scalar::all(0), is_zero);
  return ~is_zero;
}

}  // namespace lamella::apps
