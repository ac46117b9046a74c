// Where a subject was during a burst: a smooth path through time, fitted to how far pairs of
// photographs are shifted against each other.
#pragma once

#include <array>
#include <vector>

#include "base/vec.h"

namespace lamella::fit {

// The shift between two photographs; times in s from the moment that the path is zero at.
struct ShiftBetween {
  double from_s = 0, to_s = 0;
  cv::Vec2d shift{0, 0}, sigma{0, 0};  // px
};

// A polynomial through time of each axis, 0 at time 0.
class DriftPath {
 public:
  static constexpr int kMostDegree = 3;

  // At rest.
  DriftPath() = default;

  // Weighted least squares. As straight as the shifts allow: a degree is added only where it
  // explains them better by more than noise would.
  explicit DriftPath(const std::vector<ShiftBetween>& shifts);

  int degree() const { return degree_; }  // 0: nothing is known

  // px, at a time in s.
  cv::Vec2d at(double time_s) const;

  // Between two times, px: one sigma of each axis.
  cv::Vec2d sigma(double from_s, double to_s) const;

  // How far a shift is from the path, in sigmas.
  double off_sigmas(const ShiftBetween& shift) const;

 private:
  using Powers = cv::Vec<double, kMostDegree>;
  using Covariance = cv::Matx<double, kMostDegree, kMostDegree>;

  DriftPath(const std::vector<ShiftBetween>& shifts, int degree, double scale_s);
  Powers powers(double time_s) const;
  double mismatch(const std::vector<ShiftBetween>& shifts) const;

  int degree_ = 0;
  double scale_s_ = 1;
  std::array<Powers, 2> weight_{};
  std::array<Covariance, 2> covariance_{};
};

}  // namespace lamella::fit
