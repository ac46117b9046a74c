// The dipole of a kernel's tail, which is that of the deep layer.
#pragma once

#include <string>

#include "fit/gaussian_basis.h"

namespace lamella::fit {

struct DeepProfile {
  double ld_mm = 0, ld_mm_stddev = 0;
  double transport_mm = 0;  // z_r, which sets alpha' = 1 - (z_r/l_d)^2/3
  double rms = 0;           // of the logarithm, weighted by the light
  std::string at_bound;     // "l_d, 50 mm": what stands at its bound; empty: nothing
};

// What is known of a channel's skin before its tail is fitted.
struct SkinPrior {
  double transport_mm = 0.32;  // of dermis
  double reflectance = 0;      // of all diffuse light, texture included; 0: not measured
};

// Dipole to the tail of a kernel that integrates to 1, 1 to 8 mm. alpha', l_d and amplitude cannot
// all be told apart there: dermis has its transport length within a factor, unless the amplitude
// that the dipole then has is far from the measured reflectance. Under much melanin it is, and the
// nearest dipole is no dermis's.
DeepProfile fit_deep_profile(const RadialProfile& kernel, const SkinPrior& prior);

}  // namespace lamella::fit
