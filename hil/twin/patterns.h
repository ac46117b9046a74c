// What the projector shows, in its own pixels, as it reaches the subject: blurred, over a black
// that is not black.
#pragma once

#include "io/session.h"

namespace lamella::twin {

inline constexpr float kProjectorBlack = 0.01f;   // b: what a pattern value x emits is b + (1-b) x
inline constexpr float kProjectorBlurPx = 0.55f;  // sigma of the lens's blur, projector pixels

// The pattern values as written in the session format, 0 to 1, before blur and black level.
Image3 fringe_pattern(const Session& rig, int index);
Image3 stripe_pattern(const Session& rig, double shift_px);
Image3 dot_pattern(const Session& rig);
Image3 even_pattern(const Session& rig, float value);

// Emitted light of a pattern: blurred, with the black level.
Image3 emitted(const Image3& pattern);

// Emitted light seen from a point, bilinear between pixel centres; zero outside the image.
Vec3 sample_pattern(const Image3& pattern, const cv::Vec2d& uv);

}  // namespace lamella::twin
