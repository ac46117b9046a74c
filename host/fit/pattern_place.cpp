#include "fit/pattern_place.h"

#include "base/parallel.h"

namespace lamella::fit {

namespace {

constexpr float kMostSlope = 20;  // projector px a pixel: steeper is a silhouette

// Along x or y, from the neighbours that are known; 0 where there are none.
Vec2 slope(const Image2& map, int y, int x, int dy, int dx) {
  const Vec2& here = map(y, x);
  Vec2 sum(0, 0);
  float count = 0;
  for (const int side : {-1, 1}) {
    const int j = y + side * dy, i = x + side * dx;
    if (j < 0 || i < 0 || j >= map.rows || i >= map.cols) continue;
    const Vec2 step = (map(j, i) - here) * float(side);
    if (!(std::abs(step[0]) < kMostSlope && std::abs(step[1]) < kMostSlope)) continue;
    sum += step;
    ++count;
  }
  return count > 0 ? sum * (1 / count) : sum;
}

}  // namespace

Camera projector_seen_by_moved(const Camera& projector, const Vec3d& moved_mm) {
  Camera seen = projector;
  seen.translation_mm += seen.cam_from_rig * moved_mm;
  return seen;
}

Vec2 pattern_moved_px(const Camera& projector, const Vec3d& moved_mm) {
  return Vec2(projector.project(moved_mm) - projector.project({0, 0, 0}));
}

Image2 moved_projector_px(const Image2& projector_px, const PatternPlace& place) {
  const Vec2 zero(0, 0);
  if (place.moved_px == zero && place.rest_px == zero) return projector_px;
  Image2 moved(projector_px.size());
  parallel_for(moved.rows, [&](int y) {
    for (int x = 0; x < moved.cols; ++x) {
      moved(y, x) = projector_px(y, x) + place.moved_px -
                    slope(projector_px, y, x, 0, 1) * place.rest_px[0] -
                    slope(projector_px, y, x, 1, 0) * place.rest_px[1];
    }
  });
  return moved;
}

}  // namespace lamella::fit
