#include "model/single_scattering.h"

namespace lamella::model {

double amplitude_from_alpha(double alpha, double g) {
  return alpha * (1 - g) / ((1 + g) * (1 + g));
}

double alpha_from_amplitude(double amplitude, double g) {
  return amplitude * (1 + g) * (1 + g) / (1 - g);
}

float single_scattering(const TransmittanceTable& transmittance, float g, const Vec3& n,
                        const Vec3& l, const Vec3& v) {
  const float n_l = dot(n, l), n_v = dot(n, v);
  if (n_l <= 0.f || n_v <= 0.f) return 0.f;
  const float cos_l = refracted_cosine(n_l), cos_v = refracted_cosine(n_v);
  const float cosine = scattering_cosine(dot(l, v), n_l, n_v, cos_l, cos_v);
  const float alpha = float(alpha_from_amplitude(1.0, double(g)));
  return alpha * transmittance(n_l) * transmittance(n_v) * henyey_greenstein(cosine, g) /
         (cos_l + cos_v);
}

}  // namespace lamella::model
