// Three colours a pixel from a Bayer mosaic's one.
#pragma once

#include "base/vec.h"
#include "io/raw12.h"

namespace lamella {

// Bilinear: a missing colour is the mean of the nearest samples of that colour, 2 or 4 of them; at
// the borders the mosaic is mirrored, which keeps its order. Linear in the samples, exact where
// each colour is flat or a ramp, and free of overshoot. A pixel that any sample at or above
// `clipped` went into is not measured: it gets the largest of them. `mosaic` is 2 x 2 pixels or
// larger.
Image3 demosaic(const Image1& mosaic, RawPixels order, float clipped);

}  // namespace lamella
