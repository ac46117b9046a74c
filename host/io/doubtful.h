// Which pixels of a fit are shown as measured, and which are better taken from around them.
#pragma once

#include "io/layer_maps.h"

namespace lamella {

// The maps without (NaN) the pixels of which the fit itself says that it hardly knows them: each by
// its own confidence, and what rests on the projector's light also where its light was too weak to
// measure a position. Maps that have no confidence (those of truth/) stay as they are.
LayerMaps without_doubtful(const LayerMaps& maps);

}  // namespace lamella
