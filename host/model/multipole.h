// The multipole (Donner and Jensen 2005) for a slab whose lower side meets the same index: the
// shallow layer of sec. 4.2.
#pragma once

#include "model/dipole.h"

namespace lamella::model {

template <class Real>
struct Multipole {
  Real alpha;  // reduced albedo, 0 to 1
  Real ld_mm;  // diffuse mean free path in the slab's medium
  double thickness_mm;
};

inline constexpr int kPaperHalfCount = 2;  // five dipoles: i = -2 .. 2

// Depths of the i-th pair of sources: z_r,i = 2 i (d + z_b(0) + z_b(d)) + l and
// z_v,i = 2 i (d + z_b(0) + z_b(d)) - l - 2 z_b(0), with l = 1/sigma_t', D = l/3,
// z_b(0) = 2 A D, and z_b(d) = 2 D as the index is matched below.
template <class Real>
struct SourcePair {
  Real real_mm, virtual_mm;
};

template <class Real>
inline SourcePair<Real> source_pair(const Multipole<Real>& m, int i) {
  const Real l = s_from_alpha(m.alpha) * m.ld_mm;
  const Real top = 2.0 * kBoundaryFactor * l / 3.0;
  const Real bottom = 2.0 * l / 3.0;
  const Real shift = 2.0 * i * (m.thickness_mm + top + bottom);
  return {shift + l, Real(shift - l - 2.0 * top)};
}

// R(r) per mm^2, sources i = -half_count .. half_count. With half_count 0 it is eq. 7.
// Negative values are not light: a slab much thinner than a mean free path is outside diffusion.
template <class Real>
inline Real multipole_reflectance(const Multipole<Real>& m, double r_mm,
                                  int half_count = kPaperHalfCount) {
  Real sum(0.0);
  for (int i = -half_count; i <= half_count; ++i) {
    const SourcePair<Real> z = source_pair(m, i);
    sum += source_term(z.real_mm, m.ld_mm, r_mm) - source_term(z.virtual_mm, m.ld_mm, r_mm);
  }
  return m.alpha / (4.0 * M_PI) * sum;
}

// Integral of R over the plane, in closed form: alpha'/2 sum of sign(z) exp(-|z|/l_d).
template <class Real>
inline Real multipole_total(const Multipole<Real>& m, int half_count = kPaperHalfCount) {
  using std::exp;
  const auto share = [&](const Real& z) -> Real {
    if (z < 0.0) return -exp(z / m.ld_mm);
    return exp(-z / m.ld_mm);
  };
  Real sum(0.0);
  for (int i = -half_count; i <= half_count; ++i) {
    const SourcePair<Real> z = source_pair(m, i);
    sum += share(z.real_mm) - share(z.virtual_mm);
  }
  return m.alpha / 2.0 * sum;
}

// Smallest half_count whose next pair adds less than `tolerance` (relative) to the total; at most
// `limit`. 2 suffices for 4e-4 at d = 0.5 mm, alpha' = 0.9, l_d = 1 mm; 8 % is left at 0.99, 2 mm.
int half_count_for(const Multipole<double>& m, double tolerance, int limit = 64);

}  // namespace lamella::model
