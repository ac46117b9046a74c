#include "base/fill.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "base/parallel.h"

namespace lamella {

namespace {

float sum(float a) { return a; }
float sum(const Vec3& a) { return a[0] + a[1] + a[2]; }

// `value` is premultiplied by its `weight` of 0 to 1; comes back whole, with no weight left out.
template <class T>
cv::Mat_<T> interpolate(const cv::Mat_<T>& value, const Image1& weight) {
  const bool is_apex = std::min(value.rows, value.cols) <= 1;
  cv::Mat_<T> result = value.clone();
  cv::Mat_<T> coarse;
  if (!is_apex) {
    const cv::Size half((value.cols + 1) / 2, (value.rows + 1) / 2);
    cv::Mat_<T> half_value;
    Image1 half_weight;
    cv::resize(value, half_value, half, 0, 0, cv::INTER_AREA);
    cv::resize(weight, half_weight, half, 0, 0, cv::INTER_AREA);
    coarse = interpolate<T>(half_value, half_weight);
    cv::resize(coarse, coarse, value.size(), 0, 0, cv::INTER_LINEAR);
  }
  parallel_for(
      value.rows,
      [&](int y) {
        for (int x = 0; x < value.cols; ++x) {
          const float w = weight(y, x);
          if (is_apex) {
            result(y, x) = w > 0.f ? value(y, x) * (1.f / w) : T();
          } else if (w < 1.f) {
            result(y, x) = value(y, x) + coarse(y, x) * (1.f - w);
          }
        }
      },
      32);
  return result;
}

template <class T>
cv::Mat_<T> fill(const cv::Mat_<T>& image) {
  cv::Mat_<T> value(image.size(), T());
  Image1 weight(image.size(), 0.f);
  parallel_for(
      image.rows,
      [&](int y) {
        for (int x = 0; x < image.cols; ++x) {
          if (!is_finite(sum(image(y, x)))) continue;
          value(y, x) = image(y, x);
          weight(y, x) = 1.f;
        }
      },
      32);
  return interpolate<T>(value, weight);
}

}  // namespace

Image3 fill_unknown(const Image3& image) { return fill<Vec3>(image); }
Image1 fill_unknown(const Image1& image) { return fill<float>(image); }

}  // namespace lamella
