// The projected grid of black dots as skin shows it: the whole pattern, blurred on the surface by
// each Gaussian of the basis.
#pragma once

#include <vector>

#include "fit/kernel_equations.h"
#include "fit/surface_pattern.h"
#include "io/session.h"

namespace lamella::fit {

// How cycles per projector pixel become cycles per mm of surface: |f|^2 = k^T M k with
// M = (grad u . grad u, grad u . grad v, grad v . grad v), px^2 per mm^2. A circle of the pattern
// is an ellipse on a slanted surface.
using PatternMetric = cv::Vec3d;

inline PatternMetric metric_of(const PatternGradient& g) {
  return {dot(g.u, g.u), dot(g.u, g.v), dot(g.v, g.v)};
}

// One period of the pattern, 1 where it is lit, blurred by every Gaussian.
class BlurredDots {
 public:
  static constexpr int kSide = 64;  // samples of a period: a quarter of a millimetre

  using Sample = std::array<float, GaussianBasis::kSize>;

  explicit BlurredDots(std::vector<Sample> samples) : samples_(std::move(samples)) {}

  // (u, v): periods from a dot's centre, bilinear.
  void look_up(float u, float v, Sample* sample) const;

 private:
  std::vector<Sample> samples_;  // kSide x kSide, a dot's centre first
};

class DotPattern {
 public:
  explicit DotPattern(const Patterns& patterns);

  // The dot whose square of the grid holds (u, v), and where in it, in periods from its centre.
  struct Place {
    int column, row;
    float u, v;
  };
  Place place(const Vec2& projector_px) const;

  // Locally planar: `metric` is that of the dot's surroundings.
  BlurredDots blurred(const PatternMetric& metric) const;

 private:
  double pitch_px_;
  cv::Vec2d offset_px_;
  cv::Mat1f waves_;  // Fourier coefficients of one period, real as a dot is even
};

}  // namespace lamella::fit
