#include "render/surface.h"

#include <algorithm>
#include <cmath>

#include "render/map_lookup.h"

namespace lamella::render {

namespace {

// Neighbouring pixels this far apart are joined: what the camera could not see between, the side of
// a nose, is completed by a straight sheet. Further apart is another part of the body.
constexpr float kOpenMm = 40;
// A sheet is drawn but takes no part in scattering: its ends stand for themselves, not for it.
constexpr float kSheetEdge = 6;  // in spacings of the vertices
// A shadow ray is clear of the noise of its own surface this many times higher than the noise, but
// no lower than the first of these; at a grazing angle it starts no further along than the second.
constexpr float kClearNoise = 4;
constexpr float kLeastClearMm = 0.2f;
constexpr float kLongestClear = 15;  // in heights
constexpr int kNoiseReachPixels = 8;

float median(std::vector<float>* values) {
  const auto middle = values->begin() + long(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

// Median distance between horizontal neighbours, mm.
float pixel_spacing_mm(const Image3& position_mm) {
  std::vector<float> distances;
  for (int i = 0; i < position_mm.rows; i += 7) {
    for (int j = 0; j + 1 < position_mm.cols; j += 7) {
      const Vec3 d = position_mm(i, j + 1) - position_mm(i, j);
      if (is_finite(d)) distances.push_back(length(d));
    }
  }
  return distances.empty() ? 1 : median(&distances);
}

// Without the triangles that join what does not belong together or that have no place, and without
// the vertices that only they used.
FaceMesh opened_at_silhouettes(const FaceMesh& mesh) {
  FaceMesh open;
  std::vector<int> renamed(mesh.pixel.size(), -1);
  for (cv::Vec3i t : mesh.triangles) {
    const Vec3 &a = mesh.vertices_mm[size_t(t[0])], &b = mesh.vertices_mm[size_t(t[1])],
               &c = mesh.vertices_mm[size_t(t[2])];
    if (!is_finite(a) || !is_finite(b) || !is_finite(c)) continue;
    if (std::max({length(a - b), length(b - c), length(c - a)}) > kOpenMm) continue;
    for (int& v : t.val) {
      int& name = renamed[size_t(v)];
      if (name < 0) {
        name = int(open.pixel.size());
        open.pixel.push_back(mesh.pixel[size_t(v)]);
        open.vertices_mm.push_back(mesh.vertices_mm[size_t(v)]);
      }
      v = name;
    }
    open.triangles.push_back(t);
  }
  return open;
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

float position_noise_mm(const LayerMaps& maps) {
  const Image3& x = maps.position_mm;
  std::vector<float> departures;
  for (int i = 0; i < x.rows; i += 5) {
    for (int j = kNoiseReachPixels; j + kNoiseReachPixels < x.cols; j += 5) {
      const Vec3 bend =
          (x(i, j - kNoiseReachPixels) + x(i, j + kNoiseReachPixels)) * 0.5f - x(i, j);
      const float departure = std::abs(dot(bend, maps.normal_specular(i, j)));
      if (is_finite(departure)) departures.push_back(departure);
    }
  }
  return departures.empty() ? 0 : median(&departures);
}

Surface build_surface(const CompleteMaps& complete, int step) {
  const LayerMaps& maps = complete.maps;
  FaceMesh mesh = opened_at_silhouettes(mesh_face(maps.position_mm, complete.inside_px, step));
  RayScene rays(mesh.vertices_mm, mesh.triangles);
  Surface surface(std::move(mesh), std::move(rays));
  surface.clear_mm = std::max(kLeastClearMm, kClearNoise * position_noise_mm(maps));
  const size_t count = surface.normal.size();
  add_areas(kSheetEdge * float(step) * pixel_spacing_mm(maps.position_mm), &surface);
  for (size_t i = 0; i < count; ++i) {
    const Vec2& pixel = surface.mesh.pixel[i];
    surface.normal[i] = unit(look_up(maps.normal_specular, pixel));
    if (!maps.deep_ld_mm.empty()) surface.ld_mm[i] = look_up(maps.deep_ld_mm, pixel);
    surface.region[i] = maps.regions(int(pixel[1] + 0.5f), int(pixel[0] + 0.5f));
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
    point.pixel += surface.mesh.pixel[size_t(point.corner[k])] * point.weight[k];
  }
  return point;
}

bool shaded(const Surface& surface, const Vec3& position_mm, const Vec3& normal,
            const Vec3& direction, float distance_mm) {
  const float rise = std::max(1 / kLongestClear, dot(normal, direction));
  return surface.rays.occluded(position_mm, direction, surface.clear_mm / rise, distance_mm);
}

}  // namespace lamella::render
