#include "fit/surroundings.h"

#include <algorithm>
#include <cmath>

#include "base/grid_mesh.h"
#include "base/parallel.h"
#include "base/ray_scene.h"
#include "fit/smooth.h"

namespace lamella::fit {

namespace {

constexpr double kNodesMm = 1.5;        // between nodes; of the mesh: half of that
constexpr float kLongestEdgeMm = 80.f;  // of a quad of the mesh; longer is a silhouette
constexpr float kSurroundingsLiftMm =
    0.15f;  // more loses the shadows of creases, as of closed lips
constexpr float kSurroundingsFarMm = 5000.f;
constexpr int kDirections = 8192;

int32_t blocker_of(const GridMesh& mesh, const Hit& hit, const Vec3& direction, int columns) {
  if (hit.triangle < 0) return Surroundings::kFree;
  const cv::Vec3i& t = mesh.triangles[size_t(hit.triangle)];
  const auto& v = mesh.vertices_mm;
  const Vec3 outward = cross(v[t[1]] - v[t[0]], v[t[2]] - v[t[0]]);
  if (dot(outward, direction) > 0) return Surroundings::kUnknown;
  const cv::Point& p = mesh.pixel[size_t(t[0])];
  return p.y * columns + p.x;
}

}  // namespace

int Surroundings::step_for(const Camera& camera) {
  return std::max(kLeastStep_px, int(std::lround(kNodesMm / camera.pixel_mm())));
}

Surroundings place_nodes(const Image3& position_mm, const LightStage& stage, int step_px) {
  Surroundings around;
  around.step_px = step_px;
  around.leds = stage.leds().size();
  around.index =
      cv::Mat1i((position_mm.rows - 1) / step_px + 1, (position_mm.cols - 1) / step_px + 1, -1);
  for (int i = 0; i < around.index.rows; ++i) {
    for (int j = 0; j < around.index.cols; ++j) {
      const cv::Point p(j * step_px, i * step_px);
      if (!is_finite(position_mm(p))) continue;
      around.index(i, j) = int(around.pixel.size());
      around.pixel.push_back(p);
    }
  }
  around.blocker.assign(around.pixel.size() * around.leds, Surroundings::kFree);
  around.projector_hidden.assign(around.pixel.size(), 0);
  return around;
}

void look_around(const Image3& scene_mm, const Image3& normal, const LightStage& stage,
                 const Vec3d& projector_centre_mm, Surroundings* around) {
  const GridMesh mesh = mesh_from_positions(scene_mm, around->step_px / 2, kLongestEdgeMm);
  const RayScene scene(mesh.vertices_mm, mesh.triangles);
  parallel_for(
      int(around->pixel.size()),
      [&](int node) {
        const cv::Point p = around->pixel[size_t(node)];
        const Vec3 n = normal(p), origin = scene_mm(p) + n * kSurroundingsLiftMm;
        for (size_t led = 0; led < around->leds; ++led) {
          const Vec3 l = stage.direction_from(led, origin);
          int32_t& blocker = around->blocker[size_t(node) * around->leds + led];
          blocker = Surroundings::kBehind;
          if (dot(n, l) <= 0) continue;
          const Hit hit = scene.intersect(origin, l, kSurroundingsLiftMm, kSurroundingsFarMm);
          blocker = blocker_of(mesh, hit, l, scene_mm.cols);
        }
        const Vec3 l = unit(Vec3(projector_centre_mm) - origin);
        around->projector_hidden[size_t(node)] =
            scene.occluded(origin, l, kSurroundingsLiftMm, kSurroundingsFarMm);
      },
      16);
}

NodeBlend blend_nodes(const Surroundings& around, const Image1& distance_mm, int y, int x,
                      float px_mm) {
  const int step = around.step_px;
  NodeBlend blend;
  float total = 0;
  // The cell's corners first; where a silhouette cuts them all off, the next ring out.
  for (int ring = 0; ring < 2 && total <= 0; ++ring) {
    size_t count = 0;
    for (int i = y / step - ring; i <= y / step + 1 + ring; ++i) {
      for (int j = x / step - ring; j <= x / step + 1 + ring; ++j) {
        if (i < 0 || j < 0 || i >= around.index.rows || j >= around.index.cols) continue;
        const int node = around.index(i, j);
        if (node < 0 || count == 4) continue;
        const float dy = std::abs(float(y - i * step)) / float(step) / float(1 + ring);
        const float dx = std::abs(float(x - j * step)) / float(step) / float(1 + ring);
        const float w = (1.f - std::min(1.f, dy)) * (1.f - std::min(1.f, dx));
        const float apart = std::abs(distance_mm(i * step, j * step) - distance_mm(y, x));
        if (w <= 0 || !(apart < silhouette_step_mm(step * (1 + ring), px_mm))) continue;
        blend.node[count] = node;
        blend.weight[count++] = w;
        total += w;
      }
    }
  }
  if (total > 0) {
    for (float& w : blend.weight) w /= total;
  }
  return blend;
}

std::vector<float> solid_angles(const LightStage& stage) {
  std::vector<float> share(stage.leds().size(), 0.f);
  constexpr float golden = 2.39996323f;
  for (int k = 0; k < kDirections; ++k) {
    const float z = 1.f - (2.f * float(k) + 1.f) / kDirections, r = std::sqrt(1.f - z * z);
    const Vec3 d(r * std::cos(golden * float(k)), r * std::sin(golden * float(k)), z);
    size_t nearest = 0;
    float best = -2;
    for (size_t i = 0; i < share.size(); ++i) {
      const float c = dot(d, stage.leds()[i].direction);
      if (c > best) best = c, nearest = i;
    }
    if (!share.empty()) share[nearest] += 4 * kPi / kDirections;
  }
  return share;
}

}  // namespace lamella::fit
