#include "fit/pattern_extinction.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace lamella::fit {

namespace {

// Lit share of a projector pixel whose centre lies `inside_px` within the lit side of an edge.
float lit_share(double inside_px) { return float(std::clamp(0.5 + inside_px, 0.0, 1.0)); }

}  // namespace

float stripe_light(const Patterns& patterns, int index, float u_px) {
  const double period = patterns.stripe_period_px, shift = patterns.stripe_shift_px * index;
  const double from_middle = std::remainder(double(u_px) - shift - 0.25 * period, period);
  return lit_share(0.25 * period - std::abs(from_middle));
}

float dot_light(const Patterns& patterns, float u_px, float v_px) {
  const double pitch = patterns.dot_pitch_px;
  const double du = std::remainder(double(u_px) - patterns.dot_offset_px[0], pitch);
  const double dv = std::remainder(double(v_px) - patterns.dot_offset_px[1], pitch);
  return lit_share(std::hypot(du, dv) - 0.5 * patterns.dot_diameter_px);
}

void remove_pattern_extinction(const Geometry& geometry, Burst* burst) {
  const float extinction = float(burst->session->left.extinction), b = burst->black_level;
  if (extinction <= 0) return;
  const Patterns& patterns = burst->session->patterns;
  // Black emits too, and what of it leaked is gone from the BLACK that was subtracted.
  const auto emitted = [&](float pattern) { return b + (1 - b) * pattern; };
  const Image2 dots_px = moved_projector_px(geometry.projector_px, burst->dots_place);
  std::array<Image2, 4> stripes_px;
  for (size_t k = 0; k < 4; ++k) {
    stripes_px[k] = moved_projector_px(geometry.projector_px, burst->stripes_place[k]);
  }
  parallel_for(burst->regions.rows, [&](int y) {
    for (int x = 0; x < burst->regions.cols; ++x) {
      const Vec2& at = dots_px(y, x);
      if (!std::isfinite(at[0])) continue;
      const Vec3 leaked = (burst->front.parallel(y, x) - burst->front.cross(y, x)) * extinction;
      burst->dots(y, x) -= leaked * emitted(dot_light(patterns, at[0], at[1]));
      for (size_t k = 0; k < 4; ++k) {
        const float u_px = stripes_px[k](y, x)[0];
        burst->stripes[k](y, x) -= leaked * emitted(stripe_light(patterns, int(k), u_px));
      }
    }
  });
}

}  // namespace lamella::fit
