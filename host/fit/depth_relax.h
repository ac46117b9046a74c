// Depth where the projector's light is weak, grazing or missing: where the measurements and the
// normals together put it (Nehab et al. 2005, sec. 4, robustly).
#pragma once

#include "fit/depth_map.h"

namespace lamella::fit {

struct SurfaceNormals {
  Image3 unit;       // NaN where not known
  Image1 sigma_rad;  // how wrong they may be
};

// Moves the doubtful pixels of `distance_mm`: those that `measured` has no distance for, those
// beside them, in its penumbra, and those much less sure than most. Neighbours
// should lie in the plane of the normal between them, as far as a normal seen that obliquely says
// where; a measurement should be kept, as far as its sigma says. Either is given up where it is far
// from the rest: a wrong turn of the phase, a silhouette. All other pixels stay as they are.
// `distance_mm`: a start, NaN where nothing is wanted. `rounds`: after those that decide which
// neighbours are one surface.
void relax_depth(const Camera& camera, const SurfaceNormals& normals, const DepthMap& measured,
                 int rounds, Image1* distance_mm);

}  // namespace lamella::fit
