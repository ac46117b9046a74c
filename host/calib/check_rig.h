// What the manifest alone tells of a rig: can shape and normals be measured with it at all?
#pragma once

#include "calib/check.h"

namespace lamella {

// Lines for the baseline of the stereo pair and for the LEDs.
std::vector<CheckLine> check_rig(const Session& session);

}  // namespace lamella
