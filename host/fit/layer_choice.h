// One diffuse layer or two: what one dipole would be for all of a region's diffuse light, and how
// much better both layers foresee dots that neither was fitted to.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "fit/layered_kernel.h"

namespace lamella::fit {

// Which diffuse layers a fit is to use: those whose light is above the noise, or the paper's
// comparison, one dipole for all of it (its figure 7).
enum class LayerUse { kAuto, kSingle };

// Throws Error that lists the names where `name` is none of them.
LayerUse layer_use_from_name(const std::string& name);

// One dipole for all diffuse light of a region, in one channel.
struct SingleLayer {
  double ld_mm = 0, ld_mm_stddev = 0;
  double alpha = 0, alpha_stddev = 0;
  double rms = 0;  // against the two layers' kernel, relative, weighted by the light
};

// One channel of a region. Each part of its dots is left out once.
struct LayerContest {
  SingleLayer single;
  std::vector<double> gain;  // of each part: share of one dipole's squared error that both save
};

// `both`: of all the dots.
LayerContest contest_layers(const std::vector<const KernelEquations*>& dots,
                            const LayeredKernel& both, double offset_sigma, double footprint_mm);

// "both layers foresee dots that were left out with 57 +- 9 % less error (squared) than one
// dipole", over the channels together. That alone does not tell a skin of one layer: close to where
// light enters, a dipole foresees it badly too.
std::string describe_contest(const std::array<LayerContest, 3>& channels);

// Why both layers are kept: the stripes show shallow light, `shallow_share` of the diffuse light.
// The dots bear that out, or are said not to decide.
std::string reason_to_keep(const std::array<LayerContest, 3>& channels, double shallow_share);

}  // namespace lamella::fit
