#include "calib/pattern_scale.h"

namespace lamella {

PatternScale pattern_scale(const Session& session) {
  const double projector_px = session.projector.pixel_mm() / session.left.pixel_mm();
  return {session.patterns.stripe_period_px * projector_px,
          session.patterns.dot_diameter_px * projector_px};
}

bool resolves_stripes(const PatternScale& scale) {
  return scale.stripe_px >= kLeastPatternScale.stripe_px;
}

bool resolves_dots(const PatternScale& scale) { return scale.dot_px >= kLeastPatternScale.dot_px; }

}  // namespace lamella
