// A fit of fewer pixels: blocks of a burst averaged into one pixel each, and the maps back at the
// size of the photographs.
#pragma once

#include "fit/burst.h"
#include "io/layer_maps.h"

namespace lamella::fit {

// The most pixels of a block's side, `asked` at most, that leaves the session's stripes and dots
// kLeastBlockScale blocks; 1 where none does.
int resolving_bin_px(const Session& session, int asked);

// The cameras of photographs whose blocks of `bin_px` x `bin_px` pixels are one; frames as they
// are.
Session binned_session(const Session& session, int bin_px);

// `burst` as those cameras see it. A label goes to a block that it has most of; a block is clipped
// where any of its pixels is. At the right and lower edge a block may have fewer pixels. `session`
// must outlive the burst.
Burst binned_burst(const Burst& burst, const Session& session, int bin_px);

// Maps of blocks at the size of `regions`: between blocks of one surface values are interpolated;
// from beyond a silhouette nothing is. NaN outside the regions. `left`: the camera of the
// photographs.
void unbin_maps(const Labels& regions, const Camera& left, int bin_px, LayerMaps* maps);

}  // namespace lamella::fit
