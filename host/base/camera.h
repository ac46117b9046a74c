// A pinhole with OpenCV's distortion. A projector is the same thing, emitting.
#pragma once

#include <array>
#include <string>

#include "base/vec.h"

namespace lamella {

// Pixel centres are at integer coordinates; the camera frame is x right, y down, z forward.
struct Camera {
  std::string id;
  int width = 0;
  int height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixels
  std::array<double, 5> distortion{};     // k1 k2 p1 p2 k3
  Mat33d cam_from_rig = Mat33d::eye();    // rotation
  Vec3d translation_mm{0, 0, 0};          // x_cam = cam_from_rig * x_rig + translation_mm
  double saturation = 1e30;               // stored units
  double read_noise = 0;                  // one sigma, stored units
  double full_well_electrons = 0;         // at stored saturation; 0: unknown
  double extinction = 0;                  // share of S that leaks into cross

  bool has_distortion() const;

  // Centre of projection in the rig frame, mm.
  Vec3d centre_mm() const;

  // Unit direction in the rig frame of the ray that leaves the centre through pixel (u, v),
  // distortion removed (iterated as OpenCV does).
  Vec3d ray(double u, double v) const;

  // Pixel of a point in the rig frame (mm), distortion applied; NaN for one behind the camera.
  cv::Vec2d project(const Vec3d& x_rig_mm) const;

  // Depth along the optical axis, mm.
  double depth_mm(const Vec3d& x_rig_mm) const;

  // Size of a pixel on a subject at the rig's origin, mm.
  double pixel_mm() const;

  // 3x4 of an undistorted projection: (u w, v w, w) = P (x, y, z, 1).
  cv::Matx34d projection() const;
};

}  // namespace lamella
