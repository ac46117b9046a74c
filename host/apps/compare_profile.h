// The fitted scattering profile of a region against the true one.
#pragma once

#include "apps/compare_statistics.h"
#include "layers.pb.h"

namespace lamella::apps {

// A profile on evenly spaced radii.
struct TrueProfile {
  std::vector<double> r_mm;
  std::vector<double> reflectance;  // per mm^2, any scale
};

// Relative L1, by area from 0.1 to 8 mm, of the fitted dipole plus multipole against `truth`, the
// layers scaled to integrate to `deep_albedo` and `shallow_albedo` and the truth to their sum.
// NaN where the region has no dipole.
double profile_L1(const v1::Region& fitted, int channel, double deep_albedo, double shallow_albedo,
                  const TrueProfile& truth);

}  // namespace lamella::apps
