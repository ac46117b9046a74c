#include "render/surface.h"

#include <algorithm>
#include <cmath>

namespace lamella::render {

namespace {

// Neighbouring pixels this far apart are joined: what the camera could not see between, the side of
// a nose, is completed by a straight sheet. Further apart is another part of the body.
constexpr float kOpenMm = 15;
// A sheet is drawn but takes no part in scattering: its ends stand for themselves, not for it.
constexpr float kSheetEdge = 6;  // in spacings of the vertices
// A shadow ray is clear of the roughness of its own surface this high above it, or this far along.
constexpr float kClearMm = 0.2f;
constexpr float kLongestClearMm = 3;

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

void add_areas(float sheet_edge_mm, Surface* surface) {
  const auto& v = surface->mesh.vertices_mm;
  for (const cv::Vec3i& t : surface->mesh.triangles) {
    const Vec3 a = v[t[1]] - v[t[0]], b = v[t[2]] - v[t[0]];
    if (std::max({length(a), length(b), length(b - a)}) > sheet_edge_mm) continue;
    const float third = length(cross(a, b)) / 6;
    for (int k = 0; k < 3; ++k) surface->area_mm2[t[k]] += third;
  }
}

}  // namespace

Surface build_surface(const LayerMaps& maps, int step) {
  GridMesh mesh = mesh_from_positions(maps.position_mm, step, kOpenMm);
  RayScene rays(mesh.vertices_mm, mesh.triangles);
  const size_t count = mesh.vertices_mm.size();
  Surface surface{std::move(mesh),
                  std::vector<Vec3>(count),
                  std::vector<float>(count, 0.f),
                  std::vector<int>(count),
                  std::vector<Vec3>(count, Vec3(0, 0, 0)),
                  std::move(rays)};
  add_areas(kSheetEdge * float(step) * pixel_spacing_mm(maps.position_mm), &surface);
  for (size_t i = 0; i < count; ++i) {
    surface.normal[i] = maps.normal_specular(surface.mesh.pixel[i]);
    if (!maps.deep_ld_mm.empty()) surface.ld_mm[i] = maps.deep_ld_mm(surface.mesh.pixel[i]);
    surface.region[i] = maps.regions(surface.mesh.pixel[i]);
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

bool shaded(const Surface& surface, const Vec3& position_mm, const Vec3& normal,
            const Vec3& direction, float distance_mm) {
  const float rise = std::max(kClearMm / kLongestClearMm, dot(normal, direction));
  return surface.rays.occluded(position_mm, direction, kClearMm / rise, distance_mm);
}

}  // namespace lamella::render
