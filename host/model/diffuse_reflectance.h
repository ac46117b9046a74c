// Equation 8: what a semi-infinite medium reflects in all, from its reduced albedo, and back.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "model/fresnel.h"

namespace lamella::model {

// A of eq. 8 at the index of skin.
inline const double kBoundaryFactor = boundary_factor();

// s = sqrt(3 (1 - alpha')): l_d times the transport coefficient is 1/s. Eq. 8 has infinite slope in
// alpha' at 1 and none in s, so everything that inverts it works in s, 0 to sqrt(3).
template <class Real>
inline Real s_from_alpha(const Real& alpha) {
  using std::sqrt;
  return sqrt(3.0 * (1.0 - alpha));
}

template <class Real>
inline Real alpha_from_s(const Real& s) {
  return 1.0 - s * s / 3.0;
}

// Eq. 8 at s: alpha'/2 (1 + exp(-4/3 A s)) exp(-s). Falls from 1 at s = 0 to 0 at sqrt(3).
template <class Real>
inline Real diffuse_reflectance_at_s(const Real& s) {
  using std::exp;
  return alpha_from_s(s) / 2.0 * (1.0 + exp(-4.0 / 3.0 * kBoundaryFactor * s)) * exp(-s);
}

// Eq. 8 against alpha', 0 to 1.
inline double diffuse_reflectance(double alpha) {
  return diffuse_reflectance_at_s(s_from_alpha(alpha));
}

// alpha' that reflects `reflectance`. Nothing reflects 1 or more: no answer there. Light that is
// not there (0 or less, as noise makes it) has alpha' 0.
std::optional<double> alpha_from_reflectance(double reflectance);

// The same inverse for maps: a table of s over the reflectance, linear between 2048 cells; within
// 2e-6 of the exact alpha'. NaN at 1 and above.
class AlphaTable {
 public:
  AlphaTable();
  float alpha(float reflectance) const;

 private:
  std::vector<float> s_;
};

}  // namespace lamella::model
