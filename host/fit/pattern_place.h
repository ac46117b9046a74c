// Where a pattern of the projector lies on a subject that moved between its photographs.
#pragma once

#include "base/camera.h"

namespace lamella::fit {

// Of a mended photograph (motion.h). Both zero: the subject did not move.
struct PatternPlace {
  Vec2 moved_px{0, 0};  // of the projector: what lights a point, less what lights it at rest
  Vec2 rest_px{0, 0};   // of the left camera: the photograph shows what belongs this far before
};

// The projector as the subject that has moved sees it: a point of the resting subject is lit by the
// pixel that this projects it to.
Camera projector_seen_by_moved(const Camera& projector, const Vec3d& moved_mm);

// What lights a point at the rig's origin, less what would were it at rest, projector px (u, v).
Vec2 pattern_moved_px(const Camera& projector, const Vec3d& moved_mm);

// What lights every pixel of a photograph. `projector_px`: what does at rest; NaN where unknown.
Image2 moved_projector_px(const Image2& projector_px, const PatternPlace& place);

}  // namespace lamella::fit
