#include "render/rim.h"

#include <opencv2/imgproc.hpp>

#include "base/outline.h"

namespace lamella::render {

namespace {

// Shares of the square root of the known area, so that they mean the same at every resolution.
constexpr float kClosing = 0.045f;
constexpr float kSmoothing = 0.006f;
constexpr double kLeastSmoothingPx = 1.5;
constexpr float kOutsideLevel = 0.15f;  // of the blurred mask: a sigma outside

}  // namespace

Image1 rim_around(const Mask& known) {
  const float scale_px = float(std::sqrt(double(cv::countNonZero(known))));
  Image1 soft;
  closed(known, kClosing * scale_px).convertTo(soft, CV_32F, 1.0 / 255);
  const double sigma_px = std::max(kLeastSmoothingPx, double(kSmoothing * scale_px));
  cv::GaussianBlur(soft, soft, {}, sigma_px);
  Image1 distance = signed_distance_px(Mask(soft > kOutsideLevel));
  cv::GaussianBlur(distance, distance, {}, 1.5);  // less than a pixel's staircase is left
  return distance;
}

}  // namespace lamella::render
