// What leaks through the crossed analyser under stripes and dots.
#pragma once

#include "fit/geometry.h"

namespace lamella::fit {

// How much of the projector's white falls on a projector pixel of the pattern, 0 to 1, the edge
// averaged over a pixel (session-format: Patterns, as written). `u_px`, `v_px`: column and row.
float stripe_light(const Patterns& patterns, int index, float u_px);
float dot_light(const Patterns& patterns, float u_px, float v_px);

// An imperfect analyser lets a share e of S through: cross = D/2 + e S. There is no parallel
// photograph of stripes and dots, but light that keeps its polarization does not spread: S under a
// pattern is S under FRONT times the pattern's light at that very spot.
void remove_pattern_extinction(const Geometry& geometry, Burst* burst);

}  // namespace lamella::fit
