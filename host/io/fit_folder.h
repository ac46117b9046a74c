// A folder that `fit` wrote, as whoever draws from it needs it: complete, of one size, in range.
#pragma once

#include "io/layer_maps.h"

namespace lamella {

struct FitFolder {
  LayerMaps maps;
  v1::Layers layers;  // region i is label i + 1 of maps.regions
};

// Reads maps and layers.json of `folder` (a `truth/` likewise). Throws Error that names file and
// field, or pixel, where something is missing or makes no sense. A layer may be absent where every
// region says `layers.X` = false and why in `layers.why`: its maps then come back empty.
// Reflectances
// (`shallow_albedo`, `deep_albedo`, `total_albedo`) are measured whether or not a layer was fitted
// and must be there, as must the shape.
FitFolder read_fit_folder(const fs::path& folder);

}  // namespace lamella
