// layers.json of a fit against that of the truth, region by region.
#pragma once

#include "apps/compare_maps.h"
#include "io/layer_maps.h"

namespace lamella::apps {

// Adds `regions`, `g`, `summary`, `timings_s` and `checks`. `maps` gives the albedos to which the
// fitted profiles are scaled before they are held against kernels.npz, where the truth has one.
void compare_layers(ComparedMaps* maps, const v1::Layers& truth, Json* figures);

}  // namespace lamella::apps
