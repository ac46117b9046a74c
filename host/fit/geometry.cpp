#include "fit/geometry.h"

#include <algorithm>

#include "base/filled.h"
#include "base/parallel.h"
#include "fit/bled_light.h"
#include "fit/depth_fill.h"
#include "fit/depth_map.h"
#include "fit/gradient_inversion.h"
#include "fit/mesh_depth.h"
#include "fit/stereo.h"
#include "fit/triangulate.h"

namespace lamella::fit {

namespace {

constexpr float kDarkShare = 0.02f;  // of the subject's mean light: darker is not looked at
constexpr float kDarkSigmas = 6.f;   // of read noise
constexpr float kClippedSigma_mm = 1;

FringeCode fringe_code(const Session& session, const NoiseModel& noise) {
  return {session.patterns.fringe_periods, double(session.projector.width), noise};
}

// Where the projector's light is seen at all: hair, ears and neck cast shadows though no region
// holds them.
Mask lit_pixels(const Image3& front_lit, float least) {
  Mask lit(front_lit.size(), 0);
  parallel_for(lit.rows, [&](int y) {
    for (int x = 0; x < lit.cols; ++x) lit(y, x) = mean(front_lit(y, x)) > least ? 255 : 0;
  });
  return lit;
}

float least_light(const Burst& burst) {
  double sum = 0, count = 0;
  for (int y = 0; y < burst.regions.rows; y += 4) {
    for (int x = 0; x < burst.regions.cols; x += 4) {
      if (!burst.regions(y, x)) continue;
      sum += mean(burst.front_lit(y, x));
      ++count;
    }
  }
  return std::max(kDarkShare * float(sum / std::max(1., count)),
                  kDarkSigmas * std::sqrt(burst.projector_noise.variance(0)));
}

Camera projector_of_fringes(const Burst& burst) {
  return projector_seen_by_moved(burst.session->projector, burst.fringe_moved_mm);
}

// What one camera sees of the fringes.
struct FringeView {
  const std::vector<Image3>& fringe;
  const Image3& front_lit;
  const NoiseModel& noise;
  Mask clipped;  // empty: none
};

ProjectorColumns columns_of(const Burst& burst, const FringeView& view) {
  Mask lit = lit_pixels(view.front_lit, least_light(burst));
  if (!view.clipped.empty()) lit.setTo(0, view.clipped);
  return decode_columns(view.fringe, view.front_lit, lit, fringe_code(*burst.session, view.noise));
}

struct BothColumns {
  ProjectorColumns left, right;  // empty where there is no right camera
};

BothColumns decode_both(const Burst& burst) {
  BothColumns columns;
  parallel_both(
      [&] {
        columns.left =
            columns_of(burst, {burst.fringe, burst.front_lit, burst.projector_noise, Mask()});
      },
      [&] {
        if (burst.right_fringe.empty()) return;
        columns.right = columns_of(burst, {burst.right_fringe, burst.right_front_lit,
                                           burst.right_noise, burst.clipped_right});
      });
  return columns;
}

// What fringes say where they, or the white that they are held against, are clipped is better than
// nothing, and no more.
void doubt_clipped_fringes(const Burst& burst, DepthMap* depth) {
  for (const Mask* mask : {&burst.clipped_projector, &burst.clipped_fringe}) {
    if (!mask->empty()) cv::add(depth->sigma_mm, kClippedSigma_mm, depth->sigma_mm, *mask);
  }
}

// By the left camera and the projector.
DepthMap left_depth(const Burst& burst, const Camera& projector, const ProjectorColumns& columns) {
  const Session& session = *burst.session;
  DepthMap depth = measure_depth(session.left, projector, columns);
  doubt_clipped_fringes(burst, &depth);
  const Image1 share = projector_share(burst.front_lit, burst.full.cross, burst.regions > 0);
  doubt_bled_light(session.left, projector, share, &depth);
  return depth;
}

// Lets go of the fringes once they are decoded: there is nothing larger.
DepthMap triangulated_depth(Burst* burst) {
  const Session& session = *burst->session;
  const Camera projector = projector_of_fringes(*burst);
  const BothColumns columns = decode_both(*burst);
  forget_fringes(burst);
  const bool has_right = !columns.right.u_px.empty();
  DepthMap depth, right;
  parallel_both([&] { depth = left_depth(*burst, projector, columns.left); },
                [&] {
                  if (has_right) right = measure_depth(*session.right, projector, columns.right);
                });
  if (has_right) {
    depth.right = refine_with_right(session.left, *session.right, projector, right, &depth);
  } else {
    believe_alone(&depth);
  }
  return depth;
}

// Normals good enough to carry the surface over a gap: the diffuse gradients as a lone Lambertian
// surface in the middle of the rig would show them, averaged over a few pixels.
Image3 rough_normals(const Burst& burst, const Mask& lit, const DepthMap& depth) {
  Image3 normal = filled<Image3>(lit.size(), Vec3(kNaN, kNaN, kNaN));
  const LedsFrom leds(burst.session->stage, Vec3(0, 0, 0));
  const cv::Rect inside(0, 0, lit.cols, lit.rows);
  parallel_for(lit.rows, [&](int y) {
    for (int x = 0; x < lit.cols; ++x) {
      if (!lit(y, x) || !std::isnan(depth.distance_mm(y, x))) continue;
      Vec3 sum(0, 0, 0);
      float full = 0;
      for (int j = std::max(0, y - 2); j <= std::min(lit.rows - 1, y + 2); ++j) {
        for (int i = std::max(0, x - 2); i <= std::min(lit.cols - 1, x + 2); ++i) {
          if (!lit(j, i)) continue;
          const float c = burst.full.cross(j, i)[1];
          full += c;
          for (int a = 0; a < 3; ++a) sum[a] += 2 * burst.gradient[size_t(a)].cross(j, i)[1] - c;
        }
      }
      const Vec3 m = sum * (1.f / std::max(full, 1e-6f));
      normal(y, x) = invert_mean_direction(leds, 1, m, unit(m));
    }
  });
  return normal;
}

// First the regions, from their own pixels, so that no neighbour across a silhouette speaks for
// them; then the rest of what the LEDs light.
void fill(const Burst& burst, DepthMap* depth) {
  const Mask labelled = burst.regions > 0;
  const Mask lit = lit_pixels(burst.full.cross, least_light(burst)) | labelled;
  const Image3 normal = rough_normals(burst, lit, *depth);
  DepthMap subject{depth->distance_mm.clone(), depth->sigma_mm, depth->u_px, depth->px_mm};
  subject.distance_mm.setTo(kNaN, burst.regions == 0);
  fill_depth(burst.session->left, labelled, normal, &subject);
  subject.distance_mm.copyTo(depth->distance_mm, labelled);
  fill_depth(burst.session->left, lit, normal, depth);
}

Geometry geometry_at(const Burst& burst, const DepthMap& depth, const Mask& measured) {
  const Session& session = *burst.session;
  const cv::Size size = burst.regions.size();
  const Vec3 nowhere(kNaN, kNaN, kNaN);
  const Vec3d centre = session.left.centre_mm();
  Geometry g{filled<Image3>(size, nowhere),
             depth.sigma_mm,
             filled<Image2>(size, Vec2(kNaN, kNaN)),
             filled<Image3>(size, nowhere),
             filled<Image3>(size, nowhere),
             filled<Image1>(size, kNaN),
             filled<Image3>(size, nowhere),
             measured,
             depth.right};
  parallel_for(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      const float mm = depth.distance_mm(y, x);
      if (burst.regions(y, x)) {
        g.to_camera(y, x) = Vec3(-session.left.ray(x, y));
        if (!std::isnan(mm)) move_along_ray(session, {x, y}, mm, &g);
      } else if (!std::isnan(mm)) {
        g.scene_mm(y, x) = Vec3(Ray{centre, session.left.ray(x, y)}.at(mm));
      }
    }
  });
  return g;
}

}  // namespace

Geometry reconstruct_geometry(Burst burst) {
  DepthMap depth = burst.mesh ? mesh_depth(burst.session->left, *burst.mesh, burst.regions)
                              : triangulated_depth(&burst);
  const Mask measured = depth.distance_mm == depth.distance_mm;
  fill(burst, &depth);
  return geometry_at(burst, depth, measured);
}

void move_along_ray(const Session& session, const cv::Point& pixel, float distance_mm,
                    Geometry* geometry) {
  const Vec3d position =
      session.left.centre_mm() - Vec3d(geometry->to_camera(pixel)) * double(distance_mm);
  const Vec3d projector = session.projector.centre_mm();
  geometry->scene_mm(pixel) = geometry->position_mm(pixel) = Vec3(position);
  geometry->projector_px(pixel) = Vec2(session.projector.project(position));
  geometry->to_projector(pixel) = unit(Vec3(projector - position));
  geometry->projector_irradiance(pixel) = projector_irradiance(session.projector, Vec3(position));
}

}  // namespace lamella::fit
