// Masks that grow, shrink and close by a radius, and the distance to their outline.
#pragma once

#include "base/vec.h"

namespace lamella {

Mask grown(const Mask& mask, float radius_px);
Mask shrunk(const Mask& mask, float radius_px);

// Gaps narrower than twice the radius are filled. The border of the picture counts as background.
Mask closed(const Mask& mask, float radius_px);

// Protrusions narrower than twice the radius are gone.
Mask opened(const Mask& mask, float radius_px);

// Pixels to the outline, positive inside.
Image1 signed_distance_px(const Mask& mask);

}  // namespace lamella
