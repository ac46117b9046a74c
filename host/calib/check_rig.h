// What the manifest alone tells of a rig: can shape and normals be measured with it at all?
#pragma once

#include "calib/check.h"

namespace lamella {

// Lines for what the cameras and the projector see, for the baseline, which a mesh needs none of,
// and for the LEDs.
std::vector<CheckLine> check_rig(const Session& session, ShapeFrom shape = ShapeFrom::kFringes);

}  // namespace lamella
