#include "export/face_mesh.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "base/parallel.h"

namespace lamella::exporting {

namespace {

constexpr float kMetresPerMm = 1e-3f;
// Twice to four times the wanted triangles: enough for the simplifier to choose from, and quick.
constexpr int kOversampling = 3;
constexpr float kLargestError =
    0.02f;  // of the mesh's extent: a bound that the count reaches first

int grid_step(const FaceOutline& outline, int triangles) {
  const double pixels = cv::countNonZero(outline.inside_px > 0.f);
  return std::max(1, int(std::lround(std::sqrt(2.0 * pixels / (kOversampling * triangles)))));
}

Image3 smoothed(const Image3& map, int step) {
  Image3 result;
  cv::blur(map, result, cv::Size(step | 1, step | 1), cv::Point(-1, -1), cv::BORDER_REPLICATE);
  return result;
}

std::vector<uint32_t> simplified(const FaceMesh& mesh, int triangles) {
  const size_t count = mesh.triangles.size() * 3;
  std::vector<uint32_t> full(count), fewer(count);
  for (size_t i = 0; i < count; ++i) full[i] = uint32_t(mesh.triangles[i / 3][int(i % 3)]);
  if (mesh.triangles.size() <= size_t(triangles)) return full;  // the simplifier asserts otherwise
  const float* xyz = mesh.vertices_mm[0].val;
  const size_t vertices = mesh.vertices_mm.size();
  fewer.resize(meshopt_simplify(fewer.data(), full.data(), count, xyz, vertices, sizeof(Vec3),
                                size_t(triangles) * 3, kLargestError, 0, nullptr));
  meshopt_optimizeVertexCache(fewer.data(), fewer.data(), fewer.size(), vertices);
  meshopt_optimizeOverdraw(fewer.data(), fewer.data(), fewer.size(), xyz, vertices, sizeof(Vec3),
                           1.05f);
  return fewer;
}

// Sampling every `step` pixels asks for a smoothed map, but not across the outline.
Image3 smoothed_positions(const FaceMaps& face, int step) {
  Image3 result = smoothed(face.maps.position_mm, step);
  const float reach_px = 0.71f * float(step) + 1.f;
  face.maps.position_mm.copyTo(result, face.outline.inside_px < reach_px);
  return result;
}

// The direction in which u grows on the surface, square to the normal.
Vec3 tangent_at(const Image3& position_mm, const Image1& inside_px, Vec2 pixel,
                const Vec3& normal) {
  Vec2 left = pixel - Vec2(1, 0), right = pixel + Vec2(1, 0);
  if (!is_inside(inside_px, left)) left = pixel;
  if (!is_inside(inside_px, right)) right = pixel;
  const Vec3 along = sample(position_mm, right) - sample(position_mm, left);
  const Vec3 square = along - normal * dot(along, normal);
  return length(square) > 1e-4f ? unit(square) : unit(cross(Vec3(0, 1, 0), normal));
}

}  // namespace

EngineMesh engine_mesh(const FaceMaps& face, int triangles) {
  const int step = grid_step(face.outline, triangles);
  const Image3 position_mm = smoothed_positions(face, step);
  const Image3 normal = smoothed(face.maps.normal_specular, step);
  const FaceMesh mesh = mesh_face(position_mm, face.outline.inside_px, step);
  EngineMesh result;
  if (mesh.triangles.empty()) return result;
  result.indices = simplified(mesh, triangles);

  std::vector<uint32_t> renamed(mesh.vertices_mm.size());
  const size_t used = meshopt_optimizeVertexFetchRemap(renamed.data(), result.indices.data(),
                                                       result.indices.size(), renamed.size());
  for (uint32_t& i : result.indices) i = renamed[i];
  result.vertices.resize(used);
  const Vec2 size(float(position_mm.cols), float(position_mm.rows));
  parallel_for(
      int(renamed.size()),
      [&](int i) {
        if (renamed[i] == ~0u) return;
        EngineVertex& v = result.vertices[renamed[i]];
        const Vec2 p = mesh.pixel[i];
        v.position_m = mesh.vertices_mm[i] * kMetresPerMm;
        v.normal = unit(sample(normal, p));
        const Vec3 t = tangent_at(position_mm, face.outline.inside_px, p, v.normal);
        v.tangent = {t[0], t[1], t[2], 1.f};
        v.uv = {(p[0] + 0.5f) / size[0], (p[1] + 0.5f) / size[1]};
      },
      256);
  return result;
}

}  // namespace lamella::exporting
