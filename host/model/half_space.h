// Light that comes back from one homogeneous layer without an end, exactly: a Monte Carlo of the
// half-space (index kSkinIor), tabulated. Close to where light enters a dipole is wrong by more
// than what tells one layer from two.
#pragma once

#include <array>

namespace lamella::model {

// Lengths are in units of 1/mu_s', absorption is mu_a/mu_s'. Light that was scattered once is left
// out, as crossed polarizers do. The walk has Henyey-Greenstein's phase function with g = 0.67; for
// g of 0.64 to 0.69 waves differ from it by 0.001 at skin's usual absorptions and by 0.0025 at the
// strongest, for 0.8 by 0.004.
struct HalfSpaceTable {
  // Steps so fine that cubics between them are within 0.001 of the walk up to 0.13 cycles per
  // 1/mu_s'. Beyond, photons are few: halves of the walk differ by up to 0.0055.
  static constexpr int kAbsorptions = 19, kFrequencies = 25;

  static constexpr double log_absorption(int i) { return -7 + 0.5 * i; }
  static constexpr double log_frequency(int j) { return -6.2 + 0.3 * j; }
};

// Diffuse reflectance of perpendicular light, of the natural logarithm of mu_a/mu_s'; within the
// table's ends.
double half_space_reflectance(double log_absorption);

// Its inverse: the logarithm of mu_a/mu_s' of a half-space that reflects this; within the table's
// ends.
double log_absorption_of(double reflectance);

// Shares that are left of waves of exp(log_frequency) cycles per 1/mu_s', which is all that a point
// spread keeps of them: 1 for long waves. One absorption, many frequencies.
class HalfSpaceTransfer {
 public:
  explicit HalfSpaceTransfer(double log_absorption);

  double operator()(double log_frequency) const;

 private:
  std::array<double, HalfSpaceTable::kFrequencies> row_;
};

}  // namespace lamella::model
