// Maps of fewer pixels: blocks of them as one, where no texture would show more.
#pragma once

#include "export/export.h"

namespace lamella::exporting {

// Side of the blocks of pixels that textures of this size make one of, and of which there are still
// several for every triangle; at least 1.
int block_of(const LayerMaps& maps, const ExportOptions& options);

// Blocks of `block_px` pixels squared: the mean of what is known of each; of position and region,
// which have no mean over a silhouette, a pixel near the middle. Of the maps that a .glb carries.
LayerMaps reduced(const LayerMaps& maps, int block_px);

}  // namespace lamella::exporting
