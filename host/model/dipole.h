// Equation 7, the dipole (Jensen et al. 2001): how far from where it entered light leaves a
// semi-infinite medium.
#pragma once

#include <cmath>

#include "model/diffuse_reflectance.h"

namespace lamella::model {

template <class Real>
struct Dipole {
  Real alpha;  // reduced albedo alpha', 0 to 1
  Real ld_mm;  // diffuse mean free path 1/sigma_tr
};

// z_r = 1/sigma_t' = s l_d: depth of the real source, mm.
template <class Real>
inline Real transport_length_mm(const Dipole<Real>& m) {
  return s_from_alpha(m.alpha) * m.ld_mm;
}

// A number that carries its derivatives along, as Ceres' Jet: a value `a`, and their vector `v`.
template <class Real>
concept Dual = requires(Real x) {
  x.a;
  x.v;
};

// z (sigma_tr + 1/d) exp(-sigma_tr d)/d^2 with d = sqrt(r^2 + z^2): one source of eq. 7 at depth z.
// Its integral over the plane is 2 pi exp(-|z|/l_d) sign(z).
template <class Real>
inline Real source_term(const Real& z_mm, const Real& ld_mm, double r_mm) {
  using std::exp;
  using std::sqrt;
  if constexpr (Dual<Real>) {  // written out: operation by operation it takes three times as long
    const double z = z_mm.a, u = 1 / ld_mm.a;
    const double d = sqrt(r_mm * r_mm + z * z), w = 1 / d;
    const double e = exp(-d * u), g = (u + w) * e * w * w;
    const double per_z = g - z * z * e * w * w * w * (u * u + 3 * w * (u + w));
    const double per_ld = z * u * u * u * e * w;
    return Real(z * g, per_z * z_mm.v + per_ld * ld_mm.v);
  } else {
    const Real d = sqrt(r_mm * r_mm + z_mm * z_mm);
    return z_mm * (1.0 / ld_mm + 1.0 / d) * exp(-d / ld_mm) / (d * d);
  }
}

// R(r) per mm^2. Finite at r = 0 for 0 < alpha' < 1; its integral over the plane is eq. 8.
template <class Real>
inline Real dipole_reflectance(const Dipole<Real>& m, double r_mm) {
  const Real z_r = transport_length_mm(m);
  const Real z_v = z_r * (1.0 + 4.0 / 3.0 * kBoundaryFactor);
  return m.alpha / (4.0 * M_PI) *
         (source_term(z_r, m.ld_mm, r_mm) + source_term(z_v, m.ld_mm, r_mm));
}

}  // namespace lamella::model
