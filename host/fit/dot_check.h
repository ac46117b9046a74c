// Whether the photograph DOTS shows the pattern's dots where the surface would have them, in the
// light of FRONT.
#pragma once

#include "fit/geometry.h"

namespace lamella::fit {

struct DotsSeen {
  int dots = 0;  // of the pattern, that lie on the labelled surface with pixels enough
  int dark = 0;  // of these, in the middle, against their surroundings
  // DOTS/(FRONT - BLACK) between the dots, per channel, median over the dots: below 1 by what
  // scattering would have brought from them, never above. NaN without dots.
  Vec3 between{kNaN, kNaN, kNaN};
  // Of the light that is missing: how far its middle is from the dot's, median over the dots; and
  // the diameter of dots that would miss as much, whatever scattering does with it. In projector
  // pixels, NaN without dots.
  double off_px = kNaN, diameter_px = kNaN;
};

DotsSeen look_for_dots(const Burst& burst, const Geometry& geometry);

}  // namespace lamella::fit
