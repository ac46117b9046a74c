// Rays against a triangle mesh (Embree). Queries are thread-safe once built.
#pragma once

#include <memory>
#include <vector>

#include "base/vec.h"

namespace lamella {

struct Hit {
  float distance_mm = -1;  // negative: nothing was hit
  int triangle = -1;
  float u = 0, v = 0;  // barycentric weights of the second and third corner
};

class RayScene {
 public:
  RayScene(const std::vector<Vec3>& vertices_mm, const std::vector<cv::Vec3i>& triangles);
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  // Is anything between `origin` and origin + direction * far_mm? `near_mm` keeps the ray off the
  // surface it leaves.
  bool occluded(const Vec3& origin_mm, const Vec3& direction, float near_mm, float far_mm) const;

  Hit intersect(const Vec3& origin_mm, const Vec3& direction, float near_mm, float far_mm) const;

 private:
  struct Embree;
  std::unique_ptr<Embree> embree_;
};

}  // namespace lamella
