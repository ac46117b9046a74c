// The rim of a completed surface.
#pragma once

#include "base/vec.h"

namespace lamella {

// Seen from its side, a surface falls away by many millimetres a pixel, and the last pixels of
// every row end at another depth: from elsewhere the rim is a row of spikes. Averages positions
// near the rim along it, less and less inwards. `inside_px`: distance to the rim, positive inside.
void smooth_along_rim(const Image1& inside_px, Image3* position_mm);

}  // namespace lamella
