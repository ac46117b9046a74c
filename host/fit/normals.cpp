#include "fit/normals.h"

#include "base/parallel.h"
#include "fit/gradient_inversion.h"
#include "fit/occlusion.h"
#include "fit/smooth.h"

namespace lamella::fit {

namespace {

constexpr float kDiffuseSigmaPx = 2.f;
constexpr int kOcclusionRounds = 2;

cv::Mat_<DiffuseMoments> diffuse_moments(const Burst& burst) {
  cv::Mat_<DiffuseMoments> moments(burst.regions.size(), DiffuseMoments::all(0));
  parallel_for(moments.rows, [&](int y) {
    for (int x = 0; x < moments.cols; ++x) {
      const Vec3 full = burst.full.cross(y, x) * 2.f;
      DiffuseMoments& m = moments(y, x);
      for (int c = 0; c < 3; ++c) m[4 * c] = full[c];
      for (int a = 0; a < 3; ++a) {
        const Vec3 g = burst.gradient[size_t(a)].cross(y, x) * 4.f - full;
        for (int c = 0; c < 3; ++c) m[4 * c + 1 + a] = g[c];
      }
    }
  });
  return moments;
}

Image1 distances(const Burst& burst, const Image3& scene_mm) {
  const Vec3 centre(burst.session->left.centre_mm());
  Image1 mm(scene_mm.size());
  parallel_for(mm.rows, [&](int y) {
    for (int x = 0; x < mm.cols; ++x) mm(y, x) = length(scene_mm(y, x) - centre);
  });
  return mm;
}

// Everything the inversion of one channel reads.
struct DiffuseField {
  const cv::Mat_<DiffuseMoments>& moments;
  const Image1& distance_mm;
  const Surroundings* around = nullptr;  // null: no correction
  const std::vector<OcclusionAtNode>* occlusion = nullptr;
  float px_mm = 1;
};

Vec3 corrected_direction(const DiffuseField& field, int y, int x, int channel) {
  Vec3 m = mean_direction(field.moments(y, x), channel);
  if (!field.around) return m;
  const NodeBlend blend = blend_nodes(*field.around, field.distance_mm, y, x, field.px_mm);
  for (size_t k = 0; k < 4; ++k) {
    if (blend.weight[k] <= 0) break;
    m -= (*field.occlusion)[size_t(blend.node[k])].bend[size_t(channel)] * blend.weight[k];
  }
  return m;
}

void invert_pixels(const Burst& burst, const Image3& position_mm, const DiffuseField& field,
                   std::array<Image3, 3>* normal) {
  const int cells = (burst.regions.cols + kLanes - 1) / kLanes;
  parallel_for((burst.regions.rows + kLanes - 1) / kLanes, [&](int row) {
    for (int cell = 0; cell < cells; ++cell) {
      std::vector<LedsFrom> leds;  // as the cell's first labelled pixel sees them
      for (int y = row * kLanes; y < std::min((row + 1) * kLanes, burst.regions.rows); ++y) {
        const int x0 = cell * kLanes, x1 = std::min(x0 + kLanes, burst.regions.cols);
        int first = x0;
        while (first < x1 && !is_finite(position_mm(y, first))) ++first;
        if (first == x1) continue;
        if (leds.empty()) leds.emplace_back(burst.session->stage, position_mm(y, first));
        for (int c = 0; c < 3; ++c) {
          LaneVec3 m{}, n{};
          for (int x = x0; x < x1; ++x) {
            const Vec3 v = is_finite(position_mm(y, x)) ? corrected_direction(field, y, x, c)
                                                        : Vec3(0, 0, 0.5f);
            const Vec3 g = unit(v);
            for (int a = 0; a < 3; ++a) {
              m[size_t(a)][x - x0] = v[a];
              n[size_t(a)][x - x0] = g[a];
            }
          }
          n = invert_mean_direction(leds[0], c, m, n);
          for (int x = x0; x < x1; ++x) {
            if (!is_finite(position_mm(y, x))) continue;
            (*normal)[size_t(c)](y, x) = Vec3(n[0][x - x0], n[1][x - x0], n[2][x - x0]);
          }
        }
      }
    }
  });
}

}  // namespace

Normals estimate_normals(const Burst& burst, Geometry* geometry) {
  Normals n;
  const cv::Size size = burst.regions.size();
  const Vec3 nowhere(kNaN, kNaN, kNaN);
  for (Image3& d : n.diffuse) d = Image3(size, nowhere);
  n.specular_confidence = Image1(size, 0.5f);
  n.diffuse_confidence = Image1(size, 0.5f);
  n.ambient_visibility = Image1(size, 1.f);

  const Image1 distance_mm = distances(burst, geometry->scene_mm);
  const float px_mm = float(cv::norm(burst.session->left.centre_mm()) / burst.session->left.fx);
  const cv::Mat_<DiffuseMoments> moments =
      smooth_along_surface(diffuse_moments(burst), distance_mm, kDiffuseSigmaPx, px_mm);
  DiffuseField field{moments, distance_mm, nullptr, nullptr, px_mm};
  invert_pixels(burst, geometry->position_mm, field, &n.diffuse);
  const Surroundings around = look_around(geometry->scene_mm, n.diffuse[1], burst.session->stage);
  std::vector<OcclusionAtNode> occlusion;
  field.around = &around;
  field.occlusion = &occlusion;
  for (int round = 0; round < kOcclusionRounds; ++round) {
    occlusion = occlusion_at_nodes(around, burst.session->stage, geometry->position_mm,
                                   n.diffuse[1], moments);
    invert_pixels(burst, geometry->position_mm, field, &n.diffuse);
  }
  n.specular = n.diffuse[2].clone();
  return n;
}

}  // namespace lamella::fit
