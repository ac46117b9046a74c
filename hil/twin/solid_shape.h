// Solids as signed distances (mm, negative inside), joined and cut smoothly.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/vec.h"

namespace lamella::twin {

// First-order distance to an ellipsoid, exact on its surface.
inline float ellipsoid(const Vec3& p, const Vec3& centre, const Vec3& radii) {
  const Vec3 q = p - centre;
  const Vec3 a(q[0] / radii[0], q[1] / radii[1], q[2] / radii[2]);
  const Vec3 b(a[0] / radii[0], a[1] / radii[1], a[2] / radii[2]);
  const float k = length(a), slope = length(b);
  return slope > 0.f ? k * (k - 1.f) / slope : -std::min({radii[0], radii[1], radii[2]});
}

inline float ball(const Vec3& p, const Vec3& centre, float radius) {
  return length(p - centre) - radius;
}

// A rod from `a` to `b` whose radius goes from `ra` to `rb`.
inline float rod(const Vec3& p, const Vec3& a, const Vec3& b, float ra, float rb) {
  const Vec3 ab = b - a;
  const float t = std::clamp(dot(p - a, ab) / dot(ab, ab), 0.f, 1.f);
  return length(p - a - ab * t) - (ra + t * (rb - ra));
}

// Union, with a fillet of about `k` mm.
inline float join(float a, float b, float k) {
  const float h = std::max(k - std::abs(a - b), 0.f) / k;
  return std::min(a, b) - h * h * k * 0.25f;
}

// `a` without `b`, with a fillet of about `k` mm.
inline float cut(float a, float b, float k) { return -join(-a, b, k); }

inline float smooth_step(float from, float to, float x) {
  const float t = std::clamp((x - from) / (to - from), 0.f, 1.f);
  return t * t * (3.f - 2.f * t);
}

}  // namespace lamella::twin
