#include "fit/drift.h"

#include <algorithm>

namespace lamella::fit {

namespace {

// Of the sum of squares, for the two numbers that a degree adds: noise does so once in 3000 times.
constexpr double kWorthADegree = 16;

}  // namespace

DriftPath::Powers DriftPath::powers(double time_s) const {
  Powers p;
  double power = 1;
  for (int i = 0; i < degree_; ++i) p[i] = power *= time_s / scale_s_;
  return p;
}

DriftPath::DriftPath(const std::vector<ShiftBetween>& shifts, int degree, double scale_s)
    : degree_(degree), scale_s_(scale_s) {
  for (size_t axis = 0; axis < 2; ++axis) {
    Covariance normal;
    Powers right;
    for (const ShiftBetween& s : shifts) {
      const Powers p = powers(s.to_s) - powers(s.from_s);
      const double weight = 1 / (s.sigma[int(axis)] * s.sigma[int(axis)]);
      normal += p * p.t() * weight;
      right += p * (s.shift[int(axis)] * weight);
    }
    for (int i = degree; i < kMostDegree; ++i) normal(i, i) = 1;
    covariance_[axis] = normal.inv(cv::DECOMP_SVD);
    weight_[axis] = covariance_[axis] * right;
    for (int i = degree; i < kMostDegree; ++i) covariance_[axis](i, i) = 0;
  }
}

DriftPath::DriftPath(const std::vector<ShiftBetween>& shifts) {
  double scale_s = 0;
  for (const ShiftBetween& s : shifts) {
    scale_s = std::max({scale_s, std::abs(s.from_s), std::abs(s.to_s)});
  }
  if (!(scale_s > 0)) return;
  *this = DriftPath(shifts, 1, scale_s);
  for (int degree = 2; degree <= std::min(kMostDegree, int(shifts.size()) - 2); ++degree) {
    const DriftPath bent(shifts, degree, scale_s);
    if (mismatch(shifts) - bent.mismatch(shifts) > kWorthADegree) *this = bent;
  }
}

cv::Vec2d DriftPath::at(double time_s) const {
  const Powers p = powers(time_s);
  return {p.dot(weight_[0]), p.dot(weight_[1])};
}

cv::Vec2d DriftPath::sigma(double from_s, double to_s) const {
  const Powers p = powers(to_s) - powers(from_s);
  return {std::sqrt(p.dot(covariance_[0] * p)), std::sqrt(p.dot(covariance_[1] * p))};
}

double DriftPath::off_sigmas(const ShiftBetween& s) const {
  const cv::Vec2d off = at(s.to_s) - at(s.from_s) - s.shift;
  return std::hypot(off[0] / s.sigma[0], off[1] / s.sigma[1]);
}

double DriftPath::mismatch(const std::vector<ShiftBetween>& shifts) const {
  double sum = 0;
  for (const ShiftBetween& s : shifts) sum += off_sigmas(s) * off_sigmas(s);
  return sum;
}

}  // namespace lamella::fit
