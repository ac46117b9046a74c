#include "base/camera.h"

namespace lamella {

namespace {

constexpr int kMostRounds = 20;
constexpr double kSettled = 1e-12;  // of the focal length

cv::Vec2d distort(const std::array<double, 5>& k, double x, double y) {
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  return {x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x),
          y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y};
}

cv::Vec2d undistort(const std::array<double, 5>& k, double xd, double yd) {
  double x = xd, y = yd;
  for (int i = 0; i < kMostRounds; ++i) {
    const cv::Vec2d off = cv::Vec2d(xd, yd) - distort(k, x, y);
    x += off[0];
    y += off[1];
    if (std::abs(off[0]) + std::abs(off[1]) < kSettled) break;
  }
  return {x, y};
}

}  // namespace

bool Camera::has_distortion() const {
  for (double k : distortion) {
    if (k != 0) return true;
  }
  return false;
}

Vec3d Camera::centre_mm() const { return -(cam_from_rig.t() * translation_mm); }

Vec3d Camera::ray(double u, double v) const {
  double x = (u - cx) / fx, y = (v - cy) / fy;
  if (has_distortion()) {
    const cv::Vec2d p = undistort(distortion, x, y);
    x = p[0];
    y = p[1];
  }
  const Vec3d d = cam_from_rig.t() * Vec3d(x, y, 1);
  return d * (1.0 / cv::norm(d));
}

cv::Vec2d Camera::project(const Vec3d& x_rig_mm) const {
  const Vec3d p = cam_from_rig * x_rig_mm + translation_mm;
  if (p[2] <= 0) return {std::nan(""), std::nan("")};
  cv::Vec2d n(p[0] / p[2], p[1] / p[2]);
  if (has_distortion()) n = distort(distortion, n[0], n[1]);
  return {fx * n[0] + cx, fy * n[1] + cy};
}

double Camera::depth_mm(const Vec3d& x_rig_mm) const {
  return (cam_from_rig * x_rig_mm + translation_mm)[2];
}

double Camera::pixel_mm() const { return depth_mm({0, 0, 0}) / fx; }

cv::Matx34d Camera::projection() const {
  const Mat33d k(fx, 0, cx, 0, fy, cy, 0, 0, 1);
  const Mat33d kr = k * cam_from_rig;
  const Vec3d kt = k * translation_mm;
  return {kr(0, 0), kr(0, 1), kr(0, 2), kt[0],    kr(1, 0), kr(1, 1),
          kr(1, 2), kt[1],    kr(2, 0), kr(2, 1), kr(2, 2), kt[2]};
}

}  // namespace lamella
