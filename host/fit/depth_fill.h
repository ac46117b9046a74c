// Distances where the projector did not reach but the LEDs did: under the chin, at the edge that
// turns away from the projector, below its picture.
#pragma once

#include "fit/depth_map.h"

namespace lamella::fit {

// Pixels of `wanted` without a distance take it from neighbours that have one, ring by ring, along
// the plane of the normal between them. `normal`: unit, or NaN where not known (then the plane that
// faces the ray). A filled pixel's sigma grows with its way from what was measured.
inline constexpr float kFilledSigmaMm = 0.3f;  // at the edge of what was measured

void fill_depth(const Camera& camera, const Mask& wanted, const Image3& normal, DepthMap* depth);

}  // namespace lamella::fit
