#include "fit/led_witnesses.h"

#include <algorithm>

#include "base/parallel.h"
#include "fit/motion.h"
#include "fit/texture_carriers.h"

namespace lamella::fit {

namespace {

constexpr float kLeastVisible = 0.95f;
constexpr float kMostBent = 0.03f;
constexpr float kLeastFacing = 0.5f;  // cosine to the camera
constexpr double kShapeMm = 3;        // the shape's slope is taken over as much on every side
constexpr float kSteepestStep = 3;    // of positions, pixels' width a pixel: a silhouette
constexpr int kGroup_px = 48;         // a side of what errs alike

// Unit, of the surface around a pixel, from the means of its four sides; NaN at gaps and edges.
Vec3 shape_normal(const Geometry& geometry, const cv::Point& p, int reach_px, float px_mm) {
  const Image3& position = geometry.position_mm;
  const Vec3 nowhere(kNaN, kNaN, kNaN);
  if (!cv::Rect(0, 0, position.cols, position.rows).contains(p - cv::Point(reach_px, reach_px)) ||
      !cv::Rect(0, 0, position.cols, position.rows).contains(p + cv::Point(reach_px, reach_px))) {
    return nowhere;
  }
  Vec3 across(0, 0, 0), down(0, 0, 0);
  const float farthest_mm = kSteepestStep * px_mm * float(reach_px);
  for (int j = -reach_px; j <= reach_px; ++j) {
    for (int i = -reach_px; i <= reach_px; ++i) {
      const cv::Point q = p + cv::Point(i, j);
      const Vec3 step = position(q) - position(p);
      if (!geometry.measured(q) || !(length(step) < farthest_mm * 1.5f)) return nowhere;
      across += step * float(i);
      down += step * float(j);
    }
  }
  const Vec3 n = unit(lamella::cross(down, across));
  return dot(n, geometry.to_camera(p)) > 0 ? n : n * -1.f;
}

}  // namespace

std::vector<LedWitness> led_witnesses(const Burst& burst, const Geometry& geometry,
                                      const Surroundings& around,
                                      const std::vector<OcclusionAtNode>& occlusion,
                                      const cv::Mat_<DiffuseMoments>& moments) {
  const float px_mm = float(burst.session->left.pixel_mm());
  const int reach_px = std::max(2, int(std::lround(kShapeMm / double(px_mm))));
  std::vector<LedWitness> all(around.pixel.size());
  parallel_for(
      int(all.size()),
      [&](int node) {
        const cv::Point p = around.pixel[size_t(node)];
        const OcclusionAtNode& o = occlusion[size_t(node)];
        LedWitness& w = all[size_t(node)];
        w.normal = Vec3(kNaN, kNaN, kNaN);
        if (!burst.regions(p) || is_clipped(burst.clipped_led, p) ||
            o.ambient_visibility < kLeastVisible || length(o.bend[1]) > kMostBent) {
          return;
        }
        const Vec3 n = shape_normal(geometry, p, reach_px, px_mm);
        if (!(dot(n, geometry.to_camera(p)) > kLeastFacing)) return;
        const LedsFrom leds(burst.session->stage, geometry.position_mm(p));
        w.normal = n;
        w.off = mean_direction(moments(p), 1) - o.bend[1] - lambertian_mean_direction(leds, 1, n);
        w.group = (p.x / kGroup_px * 5 + p.y / kGroup_px * 7) % kWitnessGroups;
      },
      16);
  std::erase_if(all, [](const LedWitness& w) { return !is_finite(w.normal) || !is_finite(w.off); });
  return all;
}

}  // namespace lamella::fit
