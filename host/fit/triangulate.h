// Where a camera's ray meets the light sheet of one projector column.
#pragma once

#include "base/camera.h"

namespace lamella::fit {

struct Ray {
  Vec3d origin_mm;
  Vec3d direction;  // unit

  Vec3d at(double distance_mm) const { return origin_mm + direction * distance_mm; }
};

// Distance along `ray` to the sheet of light of column `u_px`, lens distortion included. NaN where
// the ray runs along the sheet or meets it behind its origin.
double distance_to_column(const Ray& ray, const Camera& projector, double u_px);

// Pixel of `x_mm` in `view`, and how fast its first coordinate moves along `direction` (px per mm).
struct Sighting {
  cv::Vec2d pixel;
  cv::Vec2d px_per_mm;
};
Sighting sight(const Camera& view, const Vec3d& x_mm, const Vec3d& direction);

}  // namespace lamella::fit
