// Modest completion of what one camera saw: small holes, and a rim beyond the last pixel.
#pragma once

#include "io/layer_maps.h"

namespace lamella::render {

// Maps with positions, normals, labels and all albedos wherever the result has a position: pixels
// that a map does not know, holes narrower than a ninth of the picture, and a rim of two pixels, so
// that the last pixel has its surface. Holes are filled by the smoothest map that fits their
// border; the rim goes on straight. A map that is empty stays empty.
LayerMaps complete_maps(const LayerMaps& maps);

// Pixels that are not known but lie between two known ones of the same row or column, no further
// apart than `longest` pixels.
Mask holes_of(const Mask& known, int longest);

// Fills the pixels of `wanted` that are not finite with the solution of Laplace's equation between
// those that are. A pixel that no known one borders on, even through others, stays as it is.
void fill_smoothly(const Mask& wanted, Image3* map);
void fill_smoothly(const Mask& wanted, Image1* map);

}  // namespace lamella::render
