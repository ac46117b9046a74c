// g of single scattering. One burst measures the amplitude alpha (1-g)/(1+g)^2 alone: backscatter
// looks the same for every g. An assumption about alpha turns it into a number.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "fit/lobe_fit.h"

namespace lamella::fit {

struct PhaseAsymmetry {
  std::array<double, 3> g{0.65, 0.65, 0.65}, g_stddev{0.1, 0.1, 0.1};
  std::string assumes;
  float mean_g() const { return float((g[0] + g[1] + g[2]) / 3); }
};

// Assumes that the scattering albedo of the top layer is the one that its diffuse reflectance gives
// by eq. 8: the reduced albedo alpha' of the whole skin, undone of its (1 - g).
PhaseAsymmetry estimate_asymmetry(const std::vector<RegionFit>& fits);

// g for which alpha (1-g)/(1+g)^2 is `amplitude`, alpha of eq. 3 from the reduced albedo.
double asymmetry_of(double amplitude, double reduced_albedo);

// alpha' whose dipole integrates to `diffuse_reflectance` (eq. 8), 0 to below 1.
double reduced_albedo_of(double diffuse_reflectance);

}  // namespace lamella::fit
