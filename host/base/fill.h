// Values for the pixels that have none, from those around them (push-pull over a pyramid).
#pragma once

#include "base/vec.h"

namespace lamella {

// Every non-finite pixel takes a smooth interpolation of the known pixels around it; known pixels
// stay as they are. An image without any known pixel comes back as zeros.
Image3 fill_unknown(const Image3& image);
Image1 fill_unknown(const Image1& image);

}  // namespace lamella
