// What a rig says of itself against what a calibration says of it.
#pragma once

#include "proto/link.pb.h"
#include "proto/session.pb.h"

namespace lamella {

// Throws Error (the rig's fault) that names the first of the number of LEDs, the numbers of the
// patterns and the projector's size in which the two differ; also where the rig does not say. What
// the calibration leaves out is the session format's default. The line begins with what is wrong:
// whose rig, the caller knows.
void require_same_rig(const v1::Welcome& welcome, const v1::Session& calibration);

// What a rig of this calibration would say of itself.
v1::Welcome rig_of(const v1::Session& calibration);

}  // namespace lamella
