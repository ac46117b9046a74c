#include "fit/geometry.h"

#include <algorithm>

#include "base/parallel.h"
#include "fit/depth_map.h"
#include "fit/stereo.h"
#include "fit/triangulate.h"

namespace lamella::fit {

namespace {

constexpr float kFilledSigmaMm = 3.f;
constexpr float kDarkShare = 0.02f;  // of the subject's mean light: darker is not looked at
constexpr float kDarkSigmas = 6.f;   // of read noise

FringeCode fringe_code(const Burst& burst) {
  return {burst.session->patterns.fringe_periods, double(burst.session->projector.width),
          burst.noise};
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
                  kDarkSigmas * std::sqrt(burst.noise.variance(0)));
}

DepthMap depth_of(const Burst& burst, const Camera& camera, const std::vector<Image3>& fringe,
                  const Image3& front_lit) {
  const Mask lit = lit_pixels(front_lit, least_light(burst));
  const ProjectorColumns columns = decode_columns(fringe, front_lit, lit, fringe_code(burst));
  return measure_depth(camera, burst.session->projector, columns);
}

// Labelled pixels without an answer take the mean of their answered neighbours, ring by ring.
void fill(const Labels& regions, DepthMap* depth) {
  std::vector<cv::Point> holes;
  for (int y = 0; y < regions.rows; ++y) {
    for (int x = 0; x < regions.cols; ++x) {
      if (regions(y, x) && std::isnan(depth->distance_mm(y, x))) holes.emplace_back(x, y);
    }
  }
  const cv::Rect inside(0, 0, regions.cols, regions.rows);
  for (size_t left = holes.size() + 1; !holes.empty() && holes.size() < left;) {
    left = holes.size();
    std::vector<std::pair<cv::Point, float>> found;
    std::vector<cv::Point> rest;
    for (const cv::Point& p : holes) {
      float sum = 0;
      int count = 0;
      for (const cv::Point& q :
           {p + cv::Point(1, 0), p - cv::Point(1, 0), p + cv::Point(0, 1), p - cv::Point(0, 1)}) {
        if (!inside.contains(q) || !regions(q) || std::isnan(depth->distance_mm(q))) continue;
        sum += depth->distance_mm(q);
        ++count;
      }
      if (count > 0) {
        found.emplace_back(p, sum / float(count));
      } else {
        rest.push_back(p);
      }
    }
    for (const auto& [p, mm] : found) {
      depth->distance_mm(p) = mm;
      depth->sigma_mm(p) = kFilledSigmaMm;
    }
    holes.swap(rest);
  }
}

Geometry geometry_at(const Burst& burst, const DepthMap& depth) {
  const Session& session = *burst.session;
  const cv::Size size = burst.regions.size();
  const Vec3 nowhere(kNaN, kNaN, kNaN);
  const Vec3d centre = session.left.centre_mm(), projector = session.projector.centre_mm();
  Geometry g{Image3(size, nowhere), depth.sigma_mm,        Image2(size, Vec2(kNaN, kNaN)),
             Image3(size, nowhere), Image3(size, nowhere), Image1(size, kNaN),
             Image3(size, nowhere)};
  parallel_for(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      if (!burst.regions(y, x) && std::isnan(depth.distance_mm(y, x))) continue;
      const Ray ray{centre, session.left.ray(x, y)};
      const Vec3d position = ray.at(depth.distance_mm(y, x));
      g.scene_mm(y, x) = Vec3(position);
      if (!burst.regions(y, x)) continue;
      g.to_camera(y, x) = Vec3(-ray.direction);
      if (std::isnan(depth.distance_mm(y, x))) continue;
      g.position_mm(y, x) = Vec3(position);
      g.projector_px(y, x) = Vec2(session.projector.project(position));
      g.to_projector(y, x) = unit(Vec3(projector - position));
      g.projector_irradiance(y, x) = projector_irradiance(session.projector, Vec3(position));
    }
  });
  return g;
}

}  // namespace

Geometry reconstruct_geometry(const Burst& burst) {
  const Session& session = *burst.session;
  DepthMap depth = depth_of(burst, session.left, burst.fringe, burst.front_lit);
  if (!burst.right_fringe.empty()) {
    const DepthMap right =
        depth_of(burst, *session.right, burst.right_fringe, burst.right_front_lit);
    refine_with_right(session.left, *session.right, session.projector, right, &depth);
  }
  fill(burst.regions, &depth);
  return geometry_at(burst, depth);
}

}  // namespace lamella::fit
