// What the manifest alone tells of a rig: can shape, normals and scattering be measured with it?
#pragma once

#include "calib/check.h"

namespace lamella {

// Lines for what the cameras and the projector see, for the baseline, which a mesh needs none of,
// for the LEDs and for how many pixels the patterns have.
std::vector<CheckLine> check_rig(const Session& session, ShapeFrom shape = ShapeFrom::kFringes);

}  // namespace lamella
