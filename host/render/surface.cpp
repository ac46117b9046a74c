#include "render/surface.h"

#include <algorithm>
#include <cmath>

namespace lamella::render {

namespace {

// Neighbouring pixels further apart than this many times the usual spacing are a silhouette.
constexpr float kOpenEdge = 6;
constexpr float kAboveMm = 0.5f;

// Median distance between horizontal neighbours, mm.
float pixel_spacing_mm(const Image3& position_mm) {
  std::vector<float> distances;
  for (int i = 0; i < position_mm.rows; i += 7) {
    for (int j = 0; j + 1 < position_mm.cols; j += 7) {
      const Vec3 d = position_mm(i, j + 1) - position_mm(i, j);
      if (is_finite(d)) distances.push_back(length(d));
    }
  }
  if (distances.empty()) return 1;
  const auto middle = distances.begin() + long(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

// Adds each triangle's share to its corners: a third of its area, and its normal times its area.
void add_triangle_shares(Surface* surface, std::vector<Vec3>* mesh_normal) {
  const auto& v = surface->mesh.vertices_mm;
  for (const cv::Vec3i& t : surface->mesh.triangles) {
    const Vec3 doubled = cross(v[t[1]] - v[t[0]], v[t[2]] - v[t[0]]);
    const float third = length(doubled) / 6;
    for (int k = 0; k < 3; ++k) {
      surface->area_mm2[t[k]] += third;
      (*mesh_normal)[t[k]] += doubled;
    }
  }
}

}  // namespace

Surface build_surface(const LayerMaps& maps, int step) {
  const float open_mm = kOpenEdge * float(step) * pixel_spacing_mm(maps.position_mm);
  GridMesh mesh = mesh_from_positions(maps.position_mm, step, open_mm);
  RayScene rays(mesh.vertices_mm, mesh.triangles);
  const size_t count = mesh.vertices_mm.size();
  Surface surface{std::move(mesh), std::vector<Vec3>(count), std::vector<float>(count, 0.f),
                  std::vector<int>(count), std::move(rays)};
  std::vector<Vec3> mesh_normal(count, Vec3(0, 0, 0));
  add_triangle_shares(&surface, &mesh_normal);
  for (size_t i = 0; i < count; ++i) {
    const cv::Point& pixel = surface.mesh.pixel[i];
    const Vec3& shading = maps.normal_specular(pixel);
    surface.normal[i] = unit(is_finite(shading) ? shading : mesh_normal[i]);
    surface.region[i] = maps.regions(pixel);
  }
  return surface;
}

SurfacePoint trace(const Surface& surface, const Vec3& origin_mm, const Vec3& direction) {
  SurfacePoint point;
  const Hit hit = surface.rays.intersect(origin_mm, direction, 1.f, 1e6f);
  if (hit.triangle < 0) return point;
  point.corner = surface.mesh.triangles[hit.triangle];
  point.weight = Vec3(1 - hit.u - hit.v, hit.u, hit.v);
  point.pixel = cv::Vec2f(0, 0);
  for (int k = 0; k < 3; ++k) {
    const cv::Point& corner = surface.mesh.pixel[point.corner[k]];
    point.pixel += cv::Vec2f(float(corner.x), float(corner.y)) * point.weight[k];
  }
  return point;
}

Vec3 above_surface(const Vec3& position_mm, const Vec3& normal) {
  return position_mm + normal * kAboveMm;
}

}  // namespace lamella::render
