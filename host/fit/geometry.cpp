#include "fit/geometry.h"

#include <algorithm>

#include "base/parallel.h"
#include "fit/fringe_phase.h"
#include "fit/triangulate.h"

namespace lamella::fit {

namespace {

constexpr float kLargestStepMm = 3.f;  // along the ray, to a neighbouring pixel
constexpr int kLeastNeighbours = 4;    // of eight that agree

FringeCode fringe_code(const Burst& burst) {
  return {burst.session->patterns.fringe_periods, double(burst.session->projector.width),
          burst.noise};
}

// Distance along every labelled pixel's ray, and its sigma; NaN where nothing was measured.
struct Distances {
  Image1 mm, sigma_mm;
};

Distances triangulate_columns(const Burst& burst, const ProjectorColumns& columns) {
  const Session& session = *burst.session;
  const Vec3d centre = session.left.centre_mm();
  Distances d{Image1(burst.regions.size(), kNaN), Image1(burst.regions.size(), kNaN)};
  parallel_for(d.mm.rows, [&](int y) {
    for (int x = 0; x < d.mm.cols; ++x) {
      const float u = columns.u_px(y, x);
      if (std::isnan(u)) continue;
      const Ray ray{centre, session.left.ray(x, y)};
      const double mm = distance_to_column(ray, session.projector, u);
      if (std::isnan(mm)) continue;
      const Sighting s = sight(session.projector, ray.at(mm), ray.direction);
      d.mm(y, x) = float(mm);
      d.sigma_mm(y, x) = columns.sigma_px(y, x) / std::max(1e-6f, std::abs(float(s.px_per_mm[0])));
    }
  });
  return d;
}

// A wrong turn of the phase leaves a pixel, or a small patch, away from its neighbours.
void reject_outliers(Distances* d) {
  const Image1 before = d->mm.clone();
  parallel_for(before.rows, [&](int y) {
    for (int x = 0; x < before.cols; ++x) {
      if (std::isnan(before(y, x))) continue;
      int agreeing = 0;
      for (int j = std::max(0, y - 1); j <= std::min(before.rows - 1, y + 1); ++j) {
        for (int i = std::max(0, x - 1); i <= std::min(before.cols - 1, x + 1); ++i) {
          agreeing += std::abs(before(j, i) - before(y, x)) < kLargestStepMm;
        }
      }
      if (agreeing <= kLeastNeighbours) d->mm(y, x) = d->sigma_mm(y, x) = kNaN;
    }
  });
}

// Labelled pixels without an answer take the mean of their answered neighbours, ring by ring.
void fill(const Labels& regions, Distances* d) {
  std::vector<cv::Point> holes;
  for (int y = 0; y < regions.rows; ++y) {
    for (int x = 0; x < regions.cols; ++x) {
      if (regions(y, x) && std::isnan(d->mm(y, x))) holes.emplace_back(x, y);
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
      for (const cv::Point& step :
           {cv::Point(1, 0), cv::Point(-1, 0), cv::Point(0, 1), cv::Point(0, -1)}) {
        if (!inside.contains(p + step) || std::isnan(d->mm(p + step))) continue;
        sum += d->mm(p + step);
        ++count;
      }
      if (count > 0)
        found.emplace_back(p, sum / float(count));
      else
        rest.push_back(p);
    }
    for (const auto& [p, mm] : found) {
      d->mm(p) = mm;
      d->sigma_mm(p) = kLargestStepMm;
    }
    holes.swap(rest);
  }
}

Geometry geometry_at(const Burst& burst, const Distances& distances) {
  const Session& session = *burst.session;
  const cv::Size size = burst.regions.size();
  const Vec3 nowhere(kNaN, kNaN, kNaN);
  const Vec3d centre = session.left.centre_mm(), projector = session.projector.centre_mm();
  Geometry g{Image3(size, nowhere), distances.sigma_mm,    Image2(size, Vec2(kNaN, kNaN)),
             Image3(size, nowhere), Image3(size, nowhere), Image1(size, kNaN)};
  parallel_for(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      if (!burst.regions(y, x)) continue;
      const Ray ray{centre, session.left.ray(x, y)};
      g.to_camera(y, x) = Vec3(-ray.direction);
      if (std::isnan(distances.mm(y, x))) continue;
      const Vec3d position = ray.at(distances.mm(y, x));
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
  const Mask wanted = burst.regions > 0;
  const ProjectorColumns left =
      decode_columns(burst.fringe, burst.front_lit, wanted, fringe_code(burst));
  Distances distances = triangulate_columns(burst, left);
  reject_outliers(&distances);
  fill(burst.regions, &distances);
  return geometry_at(burst, distances);
}

}  // namespace lamella::fit
