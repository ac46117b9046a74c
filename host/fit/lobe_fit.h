// A region's lobe and single scattering from its samples, told apart together.
//
// FRONT shows c p(h) times known factors, white, plus an amplitude per channel times known factors;
// GRADIENT_FULL shows c W[p] plus single scattering. With p a mixture of fixed lobes all of it is
// linear but for c: c from GRADIENT_FULL, mixture and amplitudes from FRONT by least squares, in
// turn. p has no scale of its own: normalising it gives c its scale.
#pragma once

#include <array>
#include <vector>

#include "fit/lobe_samples.h"
#include "fit/specular.h"

namespace lamella::fit {

using Mixture = std::array<double, kWidths>;  // weights, not negative, sum 1

struct RegionFit {
  RegionLobe lobe;
  RegionSingle single;
  std::array<double, 3> measured_single{};  // amplitude before it was judged
  int samples = 0;
  Mixture mixture{};
  double intensity = 0.25;  // c, median over the samples
  std::array<double, 3> diffuse_reflectance{};
};

// By label - 1. `previous`: of the same regions, to start from. `rounds`: of c against mixture and
// amplitudes.
std::vector<RegionFit> fit_lobes(const std::vector<LobeSample>& samples,
                                 const std::vector<RegionFit>& previous, int rounds);

// Before anything is known: a lobe as faces have it (m = 0.3) and a clean interface.
RegionFit prior_region_fit();

// p of a mixture against theta, per steradian.
std::vector<double> lobe_values(const Mixture& mixture, const std::vector<double>& theta_rad);

// 0 to pi/4 in half degrees.
std::vector<double> lobe_angles();

// One amplitude a channel for all regions that have a lobe, and one judgement whether it is there:
// their mean by inverse variance, its deviation how far they are from it.
void share_single(std::vector<RegionFit>* fits);

}  // namespace lamella::fit
