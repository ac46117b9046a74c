#include "calib/check_figures.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/parallel.h"

namespace lamella {

namespace {

constexpr size_t kMostPixels = 20000;  // a share of 1 % is known to 0.07 %
constexpr double kSensorLevels = 4096;
constexpr double kLitShare = 0.1;  // of the bright end; darker is background

double median(std::vector<float> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

template <class Value>
double median_over(const std::vector<cv::Point>& pixels, const Value& value) {
  std::vector<float> values;
  values.reserve(pixels.size());
  for (const cv::Point& p : pixels) {
    const float v = value(p);
    if (is_finite(v)) values.push_back(v);
  }
  return median(std::move(values));
}

template <class Value>
double mean_over(const std::vector<cv::Point>& pixels, const Value& value) {
  double sum = 0;
  for (const cv::Point& p : pixels) sum += value(p);
  return pixels.empty() ? 0 : sum / double(pixels.size());
}

// Brightness of the 99th percentile, over every fourth pixel of every fourth row.
double bright_end(const Image3& image) {
  std::vector<float> values;
  for (int y = 0; y < image.rows; y += 4) {
    for (int x = 0; x < image.cols; x += 4) values.push_back(mean(image(y, x)));
  }
  const auto at = values.begin() + ptrdiff_t(0.99 * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

std::vector<cv::Point> pixels_to_check(const Labels& labels, const Image3& front_cross) {
  const bool has_labels = !labels.empty();
  const double lit = has_labels ? 0 : kLitShare * bright_end(front_cross);
  const auto is_inside = [&](int y, int x) {
    return has_labels ? labels(y, x) > 0 : mean(front_cross(y, x)) > lit;
  };
  std::vector<size_t> before(size_t(front_cross.rows) + 1, 0);  // pixels above each row
  parallel_for(front_cross.rows, [&](int y) {
    for (int x = 0; x < front_cross.cols; ++x) before[size_t(y) + 1] += is_inside(y, x) ? 1 : 0;
  });
  std::partial_sum(before.begin(), before.end(), before.begin());
  const size_t step = before.back() / kMostPixels + 1;
  std::vector<cv::Point> some((before.back() + step - 1) / step);
  parallel_for(front_cross.rows, [&](int y) {
    size_t number = before[size_t(y)];
    for (int x = 0; x < front_cross.cols; ++x) {
      if (!is_inside(y, x)) continue;
      if (number % step == 0) some[number / step] = {x, y};
      ++number;
    }
  });
  return some;
}

Vec3 mean_light(const Photograph& photograph, const std::vector<cv::Point>& pixels) {
  Vec3d sum(0, 0, 0);
  for (const cv::Point& p : pixels) sum += Vec3d(photograph.radiance(p));
  return sum * (1 / std::max(1.0, double(pixels.size())));
}

double clipped_share(const std::vector<const Photograph*>& photographs,
                     const std::vector<cv::Point>& pixels) {
  return mean_over(pixels, [&](const cv::Point& p) {
    return std::any_of(photographs.begin(), photographs.end(),
                       [&](const Photograph* photograph) {
                         return !photograph->clipped.empty() && photograph->clipped(p) > 0;
                       })
               ? 1.0
               : 0.0;
  });
}

double signal_to_noise(const Photograph& photograph, const Camera& camera, const Frame& frame,
                       const std::vector<cv::Point>& pixels) {
  if (!(camera.full_well_electrons > 0) || camera.saturation > 1e29) return 0;
  const double step = camera.saturation / kSensorLevels;
  const double floor = camera.read_noise * camera.read_noise + step * step / 12;
  const double per_stored = camera.saturation / camera.full_well_electrons;
  double least = std::numeric_limits<double>::infinity();
  for (int c = 0; c < 3; ++c) {
    least = std::min(least, median_over(pixels, [&](const cv::Point& p) {
                       const float stored = photograph.radiance(p)[c] / frame.radiance_scale[c];
                       return stored / float(std::sqrt(floor + per_stored * std::max(0.f, stored)));
                     }));
  }
  return least;
}

double black_level(const CheckedBurst& burst) {
  return median_over(burst.pixels, [&](const cv::Point& p) {
    return mean(burst.black.radiance(p)) / mean(burst.front_cross.radiance(p));
  });
}

double stripe_closure(const CheckedBurst& burst) {
  return median_over(burst.pixels, [&](const cv::Point& p) {
    float sum = 0;
    for (const Photograph& s : burst.stripes) sum += mean(s.radiance(p));
    const float whole = 2 * (mean(burst.front_cross.radiance(p)) + mean(burst.black.radiance(p)));
    return std::abs(sum / whole - 1);
  });
}

double polarized_share(const Photograph& parallel, const Photograph& cross,
                       const std::vector<cv::Point>& pixels) {
  const double s = mean_over(
      pixels, [&](const cv::Point& p) { return mean(parallel.radiance(p) - cross.radiance(p)); });
  return s / mean_over(pixels, [&](const cv::Point& p) { return mean(cross.radiance(p)); });
}

// The channels carry the same cosine, a third of a period apart: x_c = 1/2 + a cos(phi + 2 pi c/3)
// has sum (x_c - mean)^2 = 3 a^2 / 2.
double fringe_contrast(const CheckedBurst& burst) {
  return median_over(burst.pixels, [&](const cv::Point& p) {
    const Vec3 black = burst.black.radiance(p);
    const Vec3 light = burst.finest_fringe.radiance(p) - black;
    const Vec3 white = burst.front_cross.radiance(p) - black;
    const Vec3 x(light[0] / white[0], light[1] / white[1], light[2] / white[2]);
    const Vec3 off = x - Vec3::all(mean(x));
    return 2 * std::sqrt(dot(off, off) * 2 / 3);
  });
}

double gradient_above_full(const CheckedBurst& burst) {
  return mean_over(burst.pixels, [&](const cv::Point& p) {
    const float limit = 1.1f * mean(burst.full_cross.radiance(p));
    return std::any_of(burst.gradient.begin(), burst.gradient.end(),
                       [&](const Photograph& g) { return mean(g.radiance(p)) > limit; })
               ? 1.0
               : 0.0;
  });
}

}  // namespace lamella
