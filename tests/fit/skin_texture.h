// Skin's fine texture in closed form, so that it can be seen anywhere between pixels.
#pragma once

#include <random>
#include <vector>

#include "base/vec.h"

namespace lamella::fit::testing {

// A sum of waves, 6 to 40 px long, of random direction and phase.
class SkinPattern {
 public:
  SkinPattern() {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> even(0, 1);
    for (int i = 0; i < 16; ++i) {
      const double k = 2 * CV_PI / (6 + 34 * even(random) * even(random));
      const double angle = 2 * CV_PI * even(random);
      waves_.push_back({k * std::cos(angle), k * std::sin(angle), 2 * CV_PI * even(random)});
    }
  }

  // About 0.5.
  double at(double x, double y) const {
    double sum = 0;
    for (const cv::Vec3d& w : waves_) sum += std::sin(w[0] * x + w[1] * y + w[2]);
    return 0.5 * (1 + 0.06 * sum);
  }

  // Of a surface that has moved by so much in the picture.
  Image1 photograph(const cv::Size& size, const cv::Vec2d& moved_px) const {
    Image1 image(size);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        image(y, x) = float(at(x - moved_px[0], y - moved_px[1]));
      }
    }
    return image;
  }

 private:
  std::vector<cv::Vec3d> waves_;
};

}  // namespace lamella::fit::testing
