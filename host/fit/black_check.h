// BLACK against STRIPES, which know the projector's black level too: over the four patterns every
// place is lit twice and dark twice.
#pragma once

#include "fit/burst.h"

namespace lamella::fit {

// Of what FRONT crossed shows, summed over the labelled pixels that nothing clips.
struct BlackLevels {
  double by_black = std::numeric_limits<double>::quiet_NaN();
  double by_stripes = std::numeric_limits<double>::quiet_NaN();
};

// `burst`: black removed from the stripes, and light that leaked through the analyser from both.
BlackLevels compare_black(const Burst& burst);

}  // namespace lamella::fit
