#include "review/orbit.h"

namespace lamella::review {

cv::Matx44f look_at(const Vec3& eye, const Vec3& target) {
  const Vec3 back = unit(eye - target);
  const Vec3 right = unit(cross(std::abs(back[1]) > 0.99f ? Vec3(0, 0, -1) : Vec3(0, 1, 0), back));
  const Vec3 up = cross(back, right);
  return {right[0], right[1], right[2], -dot(right, eye),  //
          up[0],    up[1],    up[2],    -dot(up, eye),     //
          back[0],  back[1],  back[2],  -dot(back, eye),   //
          0,        0,        0,        1};
}

cv::Matx44f perspective(float field_rad, float aspect, float near_mm, float far_mm) {
  const float f = 1.f / std::tan(field_rad / 2);
  const float depth = near_mm - far_mm;
  return {f / aspect,
          0,
          0,
          0,  //
          0,
          f,
          0,
          0,  //
          0,
          0,
          (far_mm + near_mm) / depth,
          2 * far_mm * near_mm / depth,
          0,
          0,
          -1,
          0};
}

cv::Matx44f orthographic(float half_mm, float near_mm, float far_mm) {
  const float s = 1.f / half_mm, depth = near_mm - far_mm;
  return {s, 0, 0, 0, 0, s, 0, 0, 0, 0, 2 / depth, (far_mm + near_mm) / depth, 0, 0, 0, 1};
}

Vec3 Orbit::eye_mm() const {
  const float c = std::cos(elevation_rad);
  return target_mm +
         Vec3(c * std::sin(azimuth_rad), std::sin(elevation_rad), c * std::cos(azimuth_rad)) *
             distance_mm;
}

cv::Matx44f Orbit::clip_from_rig(float aspect) const {
  cv::Matx44f shifted = cv::Matx44f::eye();
  shifted(0, 3) = shift[0];
  shifted(1, 3) = shift[1];
  const cv::Matx44f p = perspective(field_rad, aspect, 0.1f * distance_mm, 3.f * distance_mm);
  return shifted * p * look_at(eye_mm(), target_mm);
}

}  // namespace lamella::review
