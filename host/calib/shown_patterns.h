// What a rig shows against what its calibration says that it shows.
#pragma once

#include "proto/link.pb.h"
#include "proto/session.pb.h"

namespace lamella {

// Throws Error (the rig's fault) that names the first number of the patterns, or of the projector's
// size, in which the two differ; also where the rig does not say. What the calibration leaves out
// is the session format's default. The line begins with what is wrong: whose rig, the caller knows.
void require_shown_patterns(const v1::Welcome& welcome, const v1::Session& calibration);

}  // namespace lamella
