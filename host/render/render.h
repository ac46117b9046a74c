// Draws S + D of a fitted subject: a new camera, new lights, shadows, and skin that light really
// spreads in.
#pragma once

#include "io/view.h"
#include "render/subject.h"

namespace lamella::render {

struct RenderOptions {
  int environment_cells = 400;  // directions that stand for an environment map
};

// Radiance in session units, in the colours of the LEDs; 0 where a ray meets nothing.
Image3 render_view(const Subject& subject, const View& view, const RenderOptions& options = {});

}  // namespace lamella::render
