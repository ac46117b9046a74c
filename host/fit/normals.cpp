#include "fit/normals.h"

#include <algorithm>

#include "base/filled.h"
#include "base/parallel.h"
#include "fit/depth_fill.h"
#include "fit/depth_relax.h"
#include "fit/diffuse_moments.h"
#include "fit/gradient_inversion.h"
#include "fit/led_witnesses.h"
#include "fit/occlusion.h"
#include "fit/specular_normals.h"

namespace lamella::fit {

namespace {

constexpr float kTrustInBend = 0.15f;            // share of the correction that may be wrong
constexpr float kErrorAtHalfConfidence = 0.05f;  // rad
constexpr float kClippedConfidence = 0.01f;      // a weight still
constexpr float kLeastNormalSigma = 0.06f;       // rad, where shadows and bounces do not matter
constexpr float kNormalSigma = 2;                // times the error that confidence speaks of
constexpr float kHeldSigmaMm = 0.6f;             // less sure than this, a depth is only evidence

Image1 distances(const Burst& burst, const Image3& scene_mm) {
  const Vec3 centre(burst.session->left.centre_mm());
  Image1 mm(scene_mm.size());
  parallel_for(mm.rows, [&](int y) {
    for (int x = 0; x < mm.cols; ++x) mm(y, x) = length(scene_mm(y, x) - centre);
  });
  return mm;
}

// Everything the inversion reads.
struct DiffuseField {
  const LightStage& stage;
  const Image3& position_mm;
  const cv::Mat_<DiffuseMoments>& moments;
  const Image1& distance_mm;
  float px_mm;
  const Surroundings& around;
  const std::vector<OcclusionAtNode>& occlusion;
};

// One normal a node, of the green channel, with shadows and bounces as `occlusion` has them.
void invert_nodes(const DiffuseField& field, Image3* normal) {
  parallel_for(
      int(field.around.pixel.size()),
      [&](int node) {
        const cv::Point p = field.around.pixel[size_t(node)];
        const LedsFrom leds(field.stage, field.position_mm(p));
        Vec3 m = mean_direction(field.moments(p), 1);
        if (!field.occlusion.empty()) m -= field.occlusion[size_t(node)].bend[1];
        (*normal)(p) = invert_mean_direction(leds, 1, m, unit(m));
      },
      16);
}

// Eight pixels of a row.
struct Octet {
  std::array<LaneVec3, 3> mean_direction{};  // per channel, shadows and bounces removed
  std::array<float, kLanes> ambient_visibility{}, bend{};
};

Octet gather(const DiffuseField& field, int y, int x0, int x1) {
  Octet octet;
  for (int x = x0; x < x1; ++x) {
    if (!is_finite(field.position_mm(y, x))) continue;
    const NodeBlend blend = blend_nodes(field.around, field.distance_mm, y, x, field.px_mm);
    float visibility = 0, weight = 0;
    std::array<Vec3, 3> bend{};
    for (size_t k = 0; k < 4 && blend.weight[k] > 0; ++k) {
      const OcclusionAtNode& o = field.occlusion[size_t(blend.node[k])];
      for (size_t c = 0; c < 3; ++c) bend[c] += o.bend[c] * blend.weight[k];
      visibility += o.ambient_visibility * blend.weight[k];
      weight += blend.weight[k];
    }
    octet.bend[size_t(x - x0)] = length(bend[1]);
    octet.ambient_visibility[size_t(x - x0)] = weight > 0 ? visibility / weight : 1.f;
    for (int c = 0; c < 3; ++c) {
      const Vec3 m = mean_direction(field.moments(y, x), c) - bend[size_t(c)];
      for (int a = 0; a < 3; ++a) octet.mean_direction[size_t(c)][size_t(a)][x - x0] = m[a];
    }
  }
  return octet;
}

// Mean directions and the normals that they were inverted to, of one channel; zero at first.
struct Inverted {
  LaneVec3 mean_direction{}, normal{};
};

// `above`: the row before, whose normals are nearly these. A step from them is a Newton step.
void invert_octet(const DiffuseField& field, const LedsFrom& leds, const cv::Point& first,
                  std::array<Inverted, 3>* above, Normals* n) {
  const int y = first.y, x0 = first.x, x1 = std::min(x0 + kLanes, field.position_mm.cols);
  const Octet octet = gather(field, y, x0, x1);
  Lanes mismatch{};
  for (int c = 0; c < 3; ++c) {
    Inverted& before = (*above)[size_t(c)];
    const LaneVec3& m = octet.mean_direction[size_t(c)];
    const LaneVec3 guess = newton_step(before.normal, m, before.mean_direction);
    const LaneNormals lanes = invert_mean_direction(leds, c, m, guess);
    before = {m, lanes.normal};
    mismatch += lanes.mismatch * (1.f / 3);
    for (int x = x0; x < x1; ++x) {
      if (!is_finite(field.position_mm(y, x))) continue;
      for (int a = 0; a < 3; ++a) {
        n->diffuse[size_t(c)](y, x)[a] = lanes.normal[size_t(a)][x - x0];
      }
    }
  }
  for (int x = x0; x < x1; ++x) {
    if (!is_finite(field.position_mm(y, x))) continue;
    const size_t k = size_t(x - x0);
    const float error = std::hypot(kTrustInBend * octet.bend[k], mismatch[x - x0]);
    n->ambient_visibility(y, x) = octet.ambient_visibility[k];
    n->diffuse_confidence(y, x) = 1 / (1 + error / kErrorAtHalfConfidence);
  }
}

// The middle of what is known of a cell; NaN where nothing is.
Vec3 middle(const Image3& cell_mm) {
  Vec3 sum(0, 0, 0);
  float count = 0;
  for (const Vec3& p : cell_mm) {
    if (!is_finite(p)) continue;
    sum += p;
    ++count;
  }
  return sum * (1 / count);
}

// In cells of 8 x 8 pixels, which see the LEDs alike.
void invert_pixels(const DiffuseField& field, Normals* n) {
  const cv::Size size = field.position_mm.size();
  const cv::Rect picture(0, 0, size.width, size.height);
  parallel_for((size.height + kLanes - 1) / kLanes, [&](int row) {
    for (int x0 = 0; x0 < size.width; x0 += kLanes) {
      const cv::Rect cell = cv::Rect(x0, row * kLanes, kLanes, kLanes) & picture;
      const Vec3 at = middle(field.position_mm(cell));
      if (!is_finite(at)) continue;
      const LedsFrom leds(field.stage, at);
      std::array<Inverted, 3> above;
      for (int y = cell.y; y < cell.y + cell.height; ++y) {
        invert_octet(field, leds, {x0, y}, &above, n);
      }
    }
  });
}

template <class Masks>
void doubt_clipped(const Masks& clipped, Image1* confidence) {
  parallel_for(confidence->rows, [&](int y) {
    for (int x = 0; x < confidence->cols; ++x) {
      if (is_clipped(clipped, y, x)) (*confidence)(y, x) = kClippedConfidence;
    }
  });
}

// 2 G - C of a gradient that is too bright by its gain, of moments that have C first.
void mend_gradients(const LedGains& gains, float* moments) {
  for (size_t a = 0; a < 3; ++a) {
    float& moment = moments[1 + a];
    moment = (moment + moments[0]) / gains.mended_gain(a) - moments[0];
  }
}

// Of what scatters and of what is reflected.
void mend_gradients(const LedGains& gains, cv::Mat_<DiffuseMoments>* diffuse,
                    cv::Mat_<SpecularMoments>* specular) {
  parallel_for(diffuse->rows, [&](int y) {
    for (int x = 0; x < diffuse->cols; ++x) {
      for (int c = 0; c < 3; ++c) mend_gradients(gains, &(*diffuse)(y, x)[4 * c]);
      mend_gradients(gains, &(*specular)(y, x)[0]);
    }
  });
}

Image1 normal_sigma_rad(const Image1& confidence) {
  Image1 sigma(confidence.size());
  parallel_for(sigma.rows, [&](int y) {
    for (int x = 0; x < sigma.cols; ++x) {
      const float error = kErrorAtHalfConfidence * (1 / confidence(y, x) - 1);
      sigma(y, x) = kLeastNormalSigma + kNormalSigma * error;
    }
  });
  return sigma;
}

}  // namespace

// Depth was carried over gaps along rough normals, shadows and all: do it again with better ones,
// and let them speak too where the projector's light is weak.
void merge_with_normals(const Burst& burst, const Normals& normals, Geometry* geometry) {
  const Image1 distance_mm = distances(burst, geometry->scene_mm);
  const Mask sure = geometry->measured & (geometry->sigma_mm < kHeldSigmaMm);
  const Mask labelled = burst.regions > 0;
  const Image3& normal = normals.diffuse[1];
  DepthMap depth{distance_mm.clone(), geometry->sigma_mm, Image1(),
                 float(burst.session->left.pixel_mm())};
  depth.distance_mm.setTo(kNaN, ~(sure & labelled));
  fill_depth(burst.session->left, labelled, normal, &depth);
  DepthMap measured{distance_mm.clone(), geometry->sigma_mm, Image1(), depth.px_mm};
  measured.distance_mm.setTo(kNaN, ~(geometry->measured & labelled));
  if (burst.mesh) measured.penumbra_px = 0;
  relax_depth(burst.session->left, {normal, normal_sigma_rad(normals.diffuse_confidence)}, measured,
              burst.quality.relax_rounds, &depth.distance_mm);
  parallel_for(labelled.rows, [&](int y) {
    for (int x = 0; x < labelled.cols; ++x) {
      const float mm = depth.distance_mm(y, x);
      if (std::isnan(mm) || mm == distance_mm(y, x)) continue;
      move_along_ray(*burst.session, {x, y}, mm, geometry);
    }
  });
}

Normals estimate_normals(Burst burst, Geometry* geometry) {
  const Image1 distance_mm = distances(burst, geometry->scene_mm);
  const float px_mm = float(burst.session->left.pixel_mm());
  cv::Mat_<SpecularMoments> reflected = specular_moments(burst, distance_mm);
  cv::Mat_<DiffuseMoments> moments = diffuse_moments(&burst, distance_mm, px_mm);

  Normals n;
  const cv::Size size = burst.regions.size();
  const Vec3 nowhere(kNaN, kNaN, kNaN);
  for (Image3& d : n.diffuse) d = filled<Image3>(size, nowhere);
  n.diffuse_confidence = filled<Image1>(size, 0.5f);
  n.ambient_visibility = filled<Image1>(size, 1.f);

  const LightStage& stage = burst.session->stage;
  std::vector<OcclusionAtNode> occlusion;
  Surroundings around =
      place_nodes(geometry->position_mm, stage, Surroundings::step_for(burst.session->left));
  const DiffuseField field{stage,    geometry->position_mm, moments, distance_mm, px_mm, around,
                           occlusion};
  Image3 normal_at_nodes = filled<Image3>(size, nowhere);
  invert_nodes(field, &normal_at_nodes);
  look_around(geometry->scene_mm, normal_at_nodes, stage, burst.session->projector.centre_mm(),
              &around);
  const auto look_at_shadows = [&](int round) {
    if (round > 0) invert_nodes(field, &normal_at_nodes);
    occlusion = occlusion_at_nodes(around, stage, geometry->position_mm, normal_at_nodes, moments);
  };
  for (int round = 0; round < burst.quality.occlusion_rounds; ++round) look_at_shadows(round);
  n.led_gains =
      estimate_led_gains(stage, led_witnesses(burst, *geometry, around, occlusion, moments));
  if (n.led_gains.is_mended) {
    mend_gradients(n.led_gains, &moments, &reflected);
    look_at_shadows(burst.quality.occlusion_rounds);
  }
  invert_pixels(field, &n);
  moments.release();
  normal_at_nodes.release();
  n.around = std::move(around);
  doubt_clipped(burst.clipped_led_cross, &n.diffuse_confidence);
  const Image3 to_camera = geometry->to_camera;
  parallel_both([&] { merge_with_normals(burst, n, geometry); },
                [&] {
                  n.specular = add_specular_detail(burst, std::move(reflected),
                                                   {to_camera, distance_mm, px_mm}, n.diffuse[2]);
                });
  n.specular_confidence = n.diffuse_confidence.clone();
  doubt_clipped(burst.clipped_led, &n.specular_confidence);
  return n;
}

}  // namespace lamella::fit
