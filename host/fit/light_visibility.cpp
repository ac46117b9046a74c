#include "fit/light_visibility.h"

#include <algorithm>
#include <cmath>

#include "base/grid_mesh.h"
#include "base/parallel.h"
#include "base/ray_scene.h"

namespace lamella::fit {

namespace {

constexpr double kNodes_mm = 2;     // between nodes: shadows of lights half a sphere away are wider
constexpr float kMaxEdgeMm = 15.f;  // longer edges bridge air
constexpr float kLiftMm = 0.5f;     // towards the camera, off the noise of the surface
constexpr float kNearMm = 0.7f;     // along the ray, for the same reason
constexpr float kFarMm = 1000.f;    // beyond the subject

// The measured point nearest to a node within its cell, or none.
cv::Point measured_near(const Image3& position_mm, int y, int x, int step_px) {
  for (int reach = 0; reach <= step_px / 2; ++reach) {
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        if (std::max(std::abs(dy), std::abs(dx)) != reach) continue;
        const cv::Point p(x + dx, y + dy);
        if (p.x < 0 || p.y < 0 || p.x >= position_mm.cols || p.y >= position_mm.rows) continue;
        if (is_finite(position_mm(p))) return p;
      }
    }
  }
  return {-1, -1};
}

}  // namespace

int LightVisibility::step_for(const Camera& camera) {
  return std::max(kLeastStep_px, int(std::lround(kNodes_mm / camera.pixel_mm())));
}

LightVisibility::LightVisibility(const Image3& position_mm, const Image3& to_camera,
                                 const LightStage& stage, const Vec3d& projector_centre_mm,
                                 int step_px)
    : step_px_(step_px),
      rows_((position_mm.rows - 1) / step_px + 2),
      columns_((position_mm.cols - 1) / step_px + 2),
      light_count_(int(stage.leds().size()) + 1) {
  reaches_.assign(size_t(rows_) * size_t(columns_) * size_t(light_count_), 1);
  const GridMesh mesh = mesh_from_positions(position_mm, std::max(1, step_px / 2), kMaxEdgeMm);
  const RayScene scene(mesh.vertices_mm, mesh.triangles);
  parallel_for(rows_, [&](int row) {
    for (int column = 0; column < columns_; ++column) {
      const cv::Point at = measured_near(position_mm, row * step_px_, column * step_px_, step_px_);
      if (at.x < 0) continue;
      const Vec3 x_mm = position_mm(at);
      const Vec3 origin = x_mm + to_camera(at) * kLiftMm;
      uint8_t* reaches =
          &reaches_[(size_t(row) * size_t(columns_) + size_t(column)) * size_t(light_count_)];
      for (int i = 0; i < light_count_; ++i) {
        const Vec3 direction = i == projector() ? unit(Vec3(projector_centre_mm) - x_mm)
                                                : stage.direction_from(size_t(i), x_mm);
        reaches[i] = scene.occluded(origin, direction, kNearMm, kFarMm) ? 0 : 1;
      }
    }
  });
}

LightVisibility::Corners LightVisibility::corners(int y, int x) const {
  const int row = y / step_px_, column = x / step_px_;
  const float fy = float(y - row * step_px_) / float(step_px_);
  const float fx = float(x - column * step_px_) / float(step_px_);
  return {
      {node(row, column), node(row, column + 1), node(row + 1, column), node(row + 1, column + 1)},
      {(1 - fy) * (1 - fx), (1 - fy) * fx, fy * (1 - fx), fy * fx}};
}

float LightVisibility::share(int y, int x, int light) const {
  const Corners c = corners(y, x);
  float share = 0;
  for (int k = 0; k < 4; ++k) share += c.weight[k] * float(c.node[k][light]);
  return share;
}

}  // namespace lamella::fit
