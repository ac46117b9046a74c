// Where the completed surface ends: a smooth curve around what one camera saw.
#pragma once

#include "base/vec.h"

namespace lamella::render {

// Distance in pixels to the curve, positive inside. It closes notches and holes that are narrow
// beside the whole, and runs just outside the known pixels, whose own border is a staircase.
Image1 rim_around(const Mask& known);

}  // namespace lamella::render
