// How finely the left camera sees the projector's patterns, by the session's calibration alone.
#pragma once

#include "io/session.h"

namespace lamella {

// Of a subject at the rig's origin that faces the left camera, in its pixels.
struct PatternScale {
  double stripe_px;  // a period of the stripes, white and black
  double dot_px;     // the diameter of a dot
};

// With fewer the photographs do not tell what is asked of them.
inline constexpr PatternScale kLeastPatternScale{1.5, 3.5};
// Of blocks of pixels that are averaged to save time. On twins of the head that had these albedos
// were a tenth off, which were 7 % off pixel by pixel; with two thirds of them, a fifth.
inline constexpr PatternScale kLeastBlockScale{2.5, 6};

PatternScale pattern_scale(const Session& session);

bool resolves_stripes(const PatternScale& scale);
bool resolves_dots(const PatternScale& scale);

}  // namespace lamella
