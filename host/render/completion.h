// Modest completion of what one camera saw: holes, and a smooth rim beyond the last pixel.
#pragma once

#include "io/layer_maps.h"

namespace lamella::render {

struct CompleteMaps {
  LayerMaps maps;
  Image1 inside_px;  // distance to the rim of what is to be shown, positive inside
};

// Maps with positions, normals, labels and all albedos inside a smooth rim around what is known and
// four pixels beyond it. Holes are filled by the smoothest map that fits their border; the rim goes
// on straight. A map that is empty stays empty.
CompleteMaps complete_maps(const LayerMaps& measured);

// Pixels that are not known but lie between two known ones of the same row or column, no further
// apart than `longest` pixels.
Mask holes_of(const Mask& known, int longest);

// Fills the pixels of `wanted` that are not finite with the solution of Laplace's equation between
// those that are. A pixel that no known one borders on, even through others, stays as it is.
void fill_smoothly(const Mask& wanted, Image3* map);
void fill_smoothly(const Mask& wanted, Image1* map);

}  // namespace lamella::render
