// Reflection of unpolarized light at the smooth boundary of a dielectric, and refraction into it.
#pragma once

#include <cmath>

#include "base/vec.h"

namespace lamella::model {

inline constexpr double kSkinIor = 1.38;  // top layer of skin, Donner and Jensen 2006

// Share of light that is reflected on its way into a medium of relative index `eta` >= 1.
// `cos_i`: cosine of the angle of incidence, 0 to 1.
template <class Real>
inline Real fresnel_reflectance(Real cos_i, Real eta = Real(kSkinIor)) {
  const Real g = std::sqrt(eta * eta - Real(1) + cos_i * cos_i);
  const Real a = (g - cos_i) / (g + cos_i);
  const Real b = (cos_i * (g + cos_i) - Real(1)) / (cos_i * (g - cos_i) + Real(1));
  return Real(0.5) * a * a * (Real(1) + b * b);
}

// ((eta - 1)/(eta + 1))^2: reflectance at normal incidence.
double fresnel_at_normal(double eta = kSkinIor);

// Share of perfectly diffuse light that is reflected back into the medium (0.5136 at 1.38).
double diffuse_internal_reflectance(double eta = kSkinIor);

// A = (1 + F)/(1 - F) of the dipole's extrapolated boundary (3.112 at 1.38).
double boundary_factor(double eta = kSkinIor);

// Cosine inside the medium of light that meets the boundary at cosine `cos_i` outside (Snell).
template <class Real>
inline Real refracted_cosine(Real cos_i, Real eta = Real(kSkinIor)) {
  return std::sqrt(Real(1) - (Real(1) - cos_i * cos_i) / (eta * eta));
}

// `w`, unit and away from the surface with unit normal `n`, as it continues inside: l' of eq. 3,
// unit and on the same side of the surface as `w`.
Vec3 refracted_direction(const Vec3& w, const Vec3& n, float eta = float(kSkinIor));

}  // namespace lamella::model
