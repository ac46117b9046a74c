// Where the surface was carried over from what was measured to where nothing holds it: past a
// silhouette, or far into a shadow.
#pragma once

#include "io/labels.h"

namespace lamella::fit {

// 255 at the labelled pixels for which no position is to be given. `measured`: 255 where a pixel's
// own light was triangulated. A gap that is measured all around is bridged if it is narrow; one
// that is open on a side is not.
Mask unheld_pixels(const Labels& regions, const Mask& measured);

}  // namespace lamella::fit
