#include "base/rim.h"

#include <algorithm>

#include "base/face_surface.h"
#include "base/parallel.h"

namespace lamella {

namespace {

// Shares of the square root of the area inside, so that they mean the same at every resolution.
constexpr float kSigma = 0.012f;  // along the rim
constexpr float kDepth = 0.02f;   // inwards, to where nothing changes
constexpr int kTaps = 6;          // on either side, half a sigma apart

// One pixel along the rim, or nothing where it has no direction.
Vec2 tangent(const Image1& inside_px, int y, int x) {
  const Vec2 slope(inside_px(y, x + 1) - inside_px(y, x - 1),
                   inside_px(y + 1, x) - inside_px(y - 1, x));
  const float steepness = std::sqrt(slope.dot(slope));
  return steepness > 0.2f ? Vec2(-slope[1], slope[0]) * (1 / steepness) : Vec2(0, 0);
}

Vec3 averaged(const Image3& position_mm, Vec2 at, Vec2 step) {
  Vec3 sum = sample(position_mm, at);
  float weight = 1;
  for (int k = 1; k <= kTaps; ++k) {  // in pairs, so that what changes evenly stays as it is
    const Vec3 pair =
        sample(position_mm, at + step * float(k)) + sample(position_mm, at - step * float(k));
    if (!is_finite(pair)) break;
    const float w = std::exp(-0.125f * float(k * k));
    sum += pair * w;
    weight += 2 * w;
  }
  return sum * (1 / weight);
}

}  // namespace

void smooth_along_rim(const Image1& inside_px, Image3* position_mm) {
  const float scale_px = std::sqrt(float(cv::countNonZero(inside_px > 0.f)));
  const float depth_px = kDepth * scale_px, step_px = 0.5f * kSigma * scale_px;
  const Image3 before = position_mm->clone();
  parallel_for(before.rows - 2, [&](int row) {
    const int y = row + 1;
    for (int x = 1; x + 1 < before.cols; ++x) {
      const float share = std::clamp(1 - inside_px(y, x) / depth_px, 0.f, 1.f);
      if (share <= 0 || inside_px(y, x) < -depth_px || !is_finite(before(y, x))) continue;
      const Vec2 along = tangent(inside_px, y, x) * step_px;
      const Vec3 mean = averaged(before, Vec2(float(x), float(y)), along);
      if (is_finite(mean)) (*position_mm)(y, x) = before(y, x) * (1 - share) + mean * share;
    }
  });
}

}  // namespace lamella
