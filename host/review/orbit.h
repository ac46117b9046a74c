// A camera that circles the face.
#pragma once

#include "base/vec.h"

namespace lamella::review {

struct Orbit {
  Vec3 target_mm{0, 0, 0};
  float azimuth_rad = 0;  // 0: on +Z; positive: towards +X
  float elevation_rad = 0;
  float distance_mm = 600;
  float field_rad = 0.42f;  // vertical
  Vec2 shift{0, 0};         // of the picture, in its half widths and heights

  Vec3 eye_mm() const;
  cv::Matx44f clip_from_rig(float aspect) const;  // OpenGL's clip space
};

// Rows are right, up and back.
cv::Matx44f look_at(const Vec3& eye_mm, const Vec3& target_mm);

cv::Matx44f perspective(float field_rad, float aspect, float near_mm, float far_mm);

// A box of half size `half_mm` around the origin of the view.
cv::Matx44f orthographic(float half_mm, float near_mm, float far_mm);

}  // namespace lamella::review
