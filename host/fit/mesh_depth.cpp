#include "fit/mesh_depth.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "base/ray_scene.h"

namespace lamella::fit {

namespace {

// A mesh in centimetres, or in inches, covers less of its subject in millimetres.
constexpr double kLeastCovered = 0.1;
// The subject sits where the LEDs look, as far from the camera as the origin is: within this share.
constexpr double kAwayFromOrigin = 0.5;

// "180 x 240 x 130 mm about (0, 10, 20)".
std::string extent_of(const TriangleMesh& mesh) {
  Vec3 least = mesh.vertices_mm[size_t(mesh.triangles[0][0])], most = least;
  for (const cv::Vec3i& triangle : mesh.triangles) {
    for (const int corner : triangle.val) {
      for (int k = 0; k < 3; ++k) {
        const float x = mesh.vertices_mm[size_t(corner)][k];
        least[k] = std::min(least[k], x);
        most[k] = std::max(most[k], x);
      }
    }
  }
  const Vec3 size = most - least, middle = (most + least) * 0.5f;
  return fmt::format("{:.3g} x {:.3g} x {:.3g} mm about ({:.3g}, {:.3g}, {:.3g})", size[0], size[1],
                     size[2], middle[0], middle[1], middle[2]);
}

std::vector<float> seen_distances_mm(const DepthMap& depth, const Labels& regions) {
  std::vector<float> seen;
  for (int y = 0; y < regions.rows; ++y) {
    for (int x = 0; x < regions.cols; ++x) {
      const float mm = depth.distance_mm(y, x);
      if (regions(y, x) && !std::isnan(mm)) seen.push_back(mm);
    }
  }
  return seen;
}

void require_subject(const TriangleMesh& mesh, const DepthMap& depth, const Labels& regions,
                     double subject_mm) {
  std::vector<float> seen = seen_distances_mm(depth, regions);
  const double covered = double(seen.size()) / std::max(1, cv::countNonZero(regions));
  double away_mm = subject_mm;
  if (!seen.empty()) {
    const auto median = seen.begin() + long(seen.size() / 2);
    std::nth_element(seen.begin(), median, seen.end());
    away_mm = *median;
  }
  if (covered >= kLeastCovered && std::abs(away_mm - subject_mm) < kAwayFromOrigin * subject_mm) {
    return;
  }
  const std::string seen_as =
      seen.empty() ? "no triangle of it in the left camera's view of the subject"
                   : fmt::format("seen by {:.1f} % of the subject's pixels, {:.0f} mm away",
                                 100 * covered, away_mm);
  throw_bad_input(mesh.file.string(),
                  fmt::format("{}: it is {}, and the subject {:.0f} mm from the left camera, about "
                              "(0, 0, 0)",
                              seen_as, extent_of(mesh), subject_mm),
                  "give it in millimetres (a .glb in metres), in the rig's frame");
}

}  // namespace

DepthMap mesh_depth(const Camera& camera, const TriangleMesh& mesh, const Labels& regions) {
  const RayScene scene(mesh.vertices_mm, mesh.triangles);
  const Vec3d centre = camera.centre_mm();
  const double subject_mm = cv::norm(centre);
  const cv::Size size(camera.width, camera.height);
  DepthMap depth{Image1(size, kNaN), Image1(size, kNaN), Image1(size, kNaN),
                 float(subject_mm / camera.fx)};
  parallel_for(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      const Hit hit = scene.intersect(Vec3(centre), Vec3(camera.ray(x, y)), 0,
                                      std::numeric_limits<float>::infinity());
      if (hit.triangle < 0) continue;
      depth.distance_mm(y, x) = hit.distance_mm;
      depth.sigma_mm(y, x) = kMeshSigmaMm;
    }
  });
  require_subject(mesh, depth, regions, subject_mm);
  return depth;
}

}  // namespace lamella::fit
