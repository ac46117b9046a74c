#include "model/fresnel.h"

namespace lamella::model {

double fresnel_at_normal(double eta) {
  const double r = (eta - 1) / (eta + 1);
  return r * r;
}

double diffuse_internal_reflectance(double eta) {
  // By reciprocity (1 - F_inside) eta^2 = 1 - F_outside, both cosine weighted, so the integral is
  // taken outside, where there is no total reflection and the integrand is smooth.
  constexpr int kSteps = 2000;
  double outside = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double mu = (i + 0.5) / kSteps;
    outside += 2 * mu * fresnel_reflectance(mu, eta) / kSteps;
  }
  return 1 - (1 - outside) / (eta * eta);
}

double boundary_factor(double eta) {
  const double f = diffuse_internal_reflectance(eta);
  return (1 + f) / (1 - f);
}

Vec3 refracted_direction(const Vec3& w, const Vec3& n, float eta) {
  const float cos_o = dot(w, n);
  return (w - n * cos_o) * (1.f / eta) + n * refracted_cosine(cos_o, eta);
}

}  // namespace lamella::model
