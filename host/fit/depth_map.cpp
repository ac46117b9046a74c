#include "fit/depth_map.h"

#include <algorithm>

#include "base/filled.h"
#include "base/parallel.h"
#include "fit/smooth.h"
#include "fit/triangulate.h"

namespace lamella::fit {

namespace {

constexpr int kLeastNeighbours = 3;  // of eight that agree: so many has the corner of an outline
constexpr int kLonerStepPx = 3;      // neighbours may be as far apart as these see a silhouette:
constexpr int kIslandStepPx = 2;     // a wrong turn is much further
constexpr int kLeastIslandPx = 200;
constexpr float kSmoothSigmaMm = 0.375f;
constexpr float kPhaseBiasPx = 0.08f;  // of the projector's column on curved, scattering skin

DepthMap triangulate(const Camera& camera, const Camera& projector,
                     const ProjectorColumns& columns) {
  const Vec3d centre = camera.centre_mm();
  const cv::Size size = columns.u_px.size();
  DepthMap depth{filled<Image1>(size, kNaN), filled<Image1>(size, kNaN), columns.u_px.clone(),
                 float(camera.pixel_mm())};
  depth.bias_mm = filled<Image1>(size, kNaN);
  parallel_for(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      const float u = columns.u_px(y, x);
      if (std::isnan(u)) continue;
      const Ray ray{centre, camera.ray(x, y)};
      const double mm = distance_to_column(ray, projector, u);
      if (std::isnan(mm)) {
        depth.forget(y, x);
        continue;
      }
      const Sighting s = sight(projector, ray.at(mm), ray.direction);
      const float slope = std::max(1e-6f, std::abs(float(s.px_per_mm[0])));
      depth.distance_mm(y, x) = float(mm);
      depth.sigma_mm(y, x) = columns.sigma_px(y, x) / slope;
      depth.bias_mm(y, x) = kPhaseBiasPx / slope;
    }
  });
  return depth;
}

void drop_loners(DepthMap* depth) {
  const Image1 before = depth->distance_mm.clone();
  const float limit = silhouette_step_mm(kLonerStepPx, depth->px_mm);
  parallel_for(before.rows, [&](int y) {
    for (int x = 0; x < before.cols; ++x) {
      if (std::isnan(before(y, x))) continue;
      int agreeing = -1;  // the pixel agrees with itself
      for (int j = std::max(0, y - 1); j <= std::min(before.rows - 1, y + 1); ++j) {
        for (int i = std::max(0, x - 1); i <= std::min(before.cols - 1, x + 1); ++i) {
          agreeing += std::abs(before(j, i) - before(y, x)) < limit;
        }
      }
      if (agreeing < kLeastNeighbours) depth->forget(y, x);
    }
  });
}

}  // namespace

void drop_islands(DepthMap* depth, int least_px) {
  const Image1& mm = depth->distance_mm;
  const cv::Rect inside(0, 0, mm.cols, mm.rows);
  const float limit = silhouette_step_mm(kIslandStepPx, depth->px_mm);
  Mask seen(mm.size(), 0);
  std::vector<cv::Point> island;
  for (int y = 0; y < mm.rows; ++y) {
    for (int x = 0; x < mm.cols; ++x) {
      if (seen(y, x) || std::isnan(mm(y, x))) continue;
      island.assign(1, cv::Point(x, y));
      seen(y, x) = 255;
      for (size_t k = 0; k < island.size(); ++k) {
        const cv::Point p = island[k];
        for (const cv::Point& q :
             {p + cv::Point(1, 0), p - cv::Point(1, 0), p + cv::Point(0, 1), p - cv::Point(0, 1)}) {
          if (!inside.contains(q) || seen(q) || !(std::abs(mm(q) - mm(p)) < limit)) continue;
          seen(q) = 255;
          island.push_back(q);
        }
      }
      if (int(island.size()) >= least_px) continue;
      for (const cv::Point& p : island) depth->forget(p.y, p.x);
    }
  }
}

DepthMap measure_depth(const Camera& camera, const Camera& projector,
                       const ProjectorColumns& columns) {
  DepthMap depth = triangulate(camera, projector, columns);
  drop_loners(&depth);
  drop_islands(&depth, kLeastIslandPx);
  const float width_px = sigma_px(kSmoothSigmaMm, depth.px_mm, 0.3f, 3.f);
  const Image1 edges = depth.distance_mm.clone();
  const Mask measured = edges == edges;
  const SurfaceSpan span = span_for(edges, depth.px_mm, width_px);
  for (Image1* image : {&depth.u_px, &depth.distance_mm}) {
    smooth_along_surface(*image, span, width_px).copyTo(*image, measured);
  }
  return depth;
}

}  // namespace lamella::fit
