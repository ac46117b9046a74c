// Single scattering in skin, eq. 3 (Hanrahan and Krueger 1993):
// f = alpha rho_dt(l) rho_dt(v) p(cos) / (n.l' + n.v'), primes: refracted into the skin.
#pragma once

#include "base/vec.h"
#include "model/fresnel.h"
#include "model/henyey_greenstein.h"
#include "model/transmittance.h"

namespace lamella::model {

// Derived from scratch eq. 3 has a further 1/ior^2 (radiance that leaves the denser medium
// spreads). As printed, alpha is the scattering albedo divided by ior^2.
inline constexpr double kAlbedoPerAlpha = kSkinIor * kSkinIor;

// Both ways between alpha and what backscatter measures, the amplitude alpha (1-g)/(1+g)^2.
double amplitude_from_alpha(double alpha, double g);
double alpha_from_amplitude(double amplitude, double g);

// -l'.v': cosine between the propagation directions inside the skin, from outside cosines.
template <class Real>
inline Real scattering_cosine(Real l_v, Real n_l, Real n_v, Real cos_l_inside, Real cos_v_inside) {
  constexpr Real kEta2 = Real(kSkinIor * kSkinIor);
  return -((l_v - n_l * n_v) / kEta2 + cos_l_inside * cos_v_inside);
}

// f with amplitude 1, per steradian; 0 where light or camera are below the surface.
// All vectors unit, `l` and `v` away from the surface.
float single_scattering(const TransmittanceTable& transmittance, float g, const Vec3& n,
                        const Vec3& l, const Vec3& v);

}  // namespace lamella::model
