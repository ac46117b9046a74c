#include "fit/triangulate.h"

namespace lamella::fit {

namespace {

constexpr int kDistortionRounds = 6;
constexpr double kSettledPx = 1e-5;
constexpr double kStepMm = 0.05;

double distance_to_undistorted_column(const Ray& ray, const Camera& projector, double u_px) {
  // Points of the sheet: fx x + (cx - u) z = 0 in the projector's frame.
  const Vec3d normal(projector.fx, 0, projector.cx - u_px);
  const Vec3d origin = projector.cam_from_rig * ray.origin_mm + projector.translation_mm;
  const Vec3d direction = projector.cam_from_rig * ray.direction;
  const double along = normal.dot(direction);
  if (std::abs(along) < 1e-9 * projector.fx) return std::nan("");
  const double distance = -normal.dot(origin) / along;
  return distance > 0 ? distance : std::nan("");
}

}  // namespace

double distance_to_column(const Ray& ray, const Camera& projector, double u_px) {
  double distance = distance_to_undistorted_column(ray, projector, u_px);
  if (!projector.has_distortion()) return distance;
  // A distorted sheet is not flat: aim at the flat one that passes through the same point.
  double aim = u_px;
  for (int i = 0; i < kDistortionRounds; ++i) {
    const double off_px = u_px - projector.project(ray.at(distance))[0];
    if (std::abs(off_px) < kSettledPx) break;
    aim += off_px;
    distance = distance_to_undistorted_column(ray, projector, aim);
  }
  return distance;
}

Sighting sight(const Camera& view, const Vec3d& x_mm, const Vec3d& direction) {
  const cv::Vec2d here = view.project(x_mm);
  const cv::Vec2d there = view.project(x_mm + direction * kStepMm);
  return {here, (there - here) * (1 / kStepMm)};
}

}  // namespace lamella::fit
