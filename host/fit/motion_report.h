// What is told of the subject's motion.
#pragma once

#include <vector>

#include "calib/check.h"
#include "fit/motion.h"
#include "layers.pb.h"

namespace lamella::fit {

v1::Motion message_from_motion(const Motion& motion);

// A poor line for motion beyond what shifting photographs mends, and one for photographs that are
// off the smooth path.
std::vector<CheckLine> judge_motion(const Motion& motion);

}  // namespace lamella::fit
