// The maps of `truth/`: what a perfect fit of this subject would find, by the definitions of the
// session format.
#pragma once

#include "io/layer_maps.h"
#include "twin/photographer.h"
#include "twin/truth_fits.h"

namespace lamella::twin {

struct RegionTruth {
  std::array<DipoleFit, 3> dipole;  // nearest to the whole profile
};
std::array<RegionTruth, kRegionCount> region_truth(const SkinProfiles& profiles);

struct TruthMaps {
  LayerMaps maps;
  Image3 shallow_physical, deep_physical;  // light that never left the epidermis, and the rest
};

TruthMaps truth_maps(const Photographer& photographer,
                     const std::array<RegionTruth, kRegionCount>& regions);

// Labels of the left camera's pixels.
Labels truth_labels(const Photographer& photographer);

}  // namespace lamella::twin
