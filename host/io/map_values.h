// What a number in a map can be. A map that was damaged, or that another program wrote, decodes as
// well as any other, and is drawn and exported as it is.
#pragma once

#include "io/layer_maps.h"

namespace lamella {

// Throws Error that names the first map of `folder`, pixel and number that no fit gives: a
// reflectance of -5, a normal that is not of length 1, none where `confidence` is above 0.
void require_possible_values(const fs::path& folder, const LayerMaps& maps);

}  // namespace lamella
