// The skin as a mesh: what is needed at each of its vertices to light it and to let light scatter.
#pragma once

#include <vector>

#include "base/face_surface.h"
#include "base/ray_scene.h"
#include "render/completion.h"

namespace lamella::render {

struct Surface {
  Surface(FaceMesh face, RayScene scene)
      : mesh(std::move(face)),
        normal(mesh.vertices_mm.size()),
        area_mm2(mesh.vertices_mm.size(), 0.f),
        region(mesh.vertices_mm.size(), 0),
        ld_mm(mesh.vertices_mm.size(), Vec3(0, 0, 0)),
        rays(std::move(scene)) {}

  FaceMesh mesh;
  std::vector<Vec3> normal;     // shading normal of each vertex, unit
  std::vector<float> area_mm2;  // a third of the triangles around each vertex
  std::vector<int> region;      // label of each vertex, 0 where it has none
  std::vector<Vec3> ld_mm;      // diffuse mean free path at each vertex; empty map: all 0
  float clear_mm = 0;           // shadow rays start where they are this high above the surface
  RayScene rays;
};

// What neither shape nor shading explains in a map of positions: the median departure, mm along the
// normal, of a pixel from the middle of two that are 8 pixels to its left and right.
float position_noise_mm(const LayerMaps& maps);

// Every `step`-th pixel of the completed maps becomes a vertex, those of the rim lie on it. Wide
// silhouettes are left open.
Surface build_surface(const CompleteMaps& complete, int step);

// A point on the surface that a camera ray meets.
struct SurfacePoint {
  cv::Vec3i corner{-1, -1, -1};  // vertices
  Vec3 weight;                   // of each, sum 1
  cv::Vec2f pixel;               // in the maps, x then y
  bool on_surface() const { return corner[0] >= 0; }
};

SurfacePoint trace(const Surface& surface, const Vec3& origin_mm, const Vec3& direction);

// The value of a vertex attribute at a point.
template <class Value>
Value interpolate(const std::vector<Value>& values, const SurfacePoint& p) {
  return values[p.corner[0]] * p.weight[0] + values[p.corner[1]] * p.weight[1] +
         values[p.corner[2]] * p.weight[2];
}

// Does anything stand between a point of the surface and a light? The ray is tested from where it
// is clear of the noise of the measured surface, without moving its start sideways.
bool shaded(const Surface& surface, const Vec3& position_mm, const Vec3& normal,
            const Vec3& direction, float distance_mm);

}  // namespace lamella::render
