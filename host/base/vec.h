// Small vectors and images: OpenCV's, under the names the project uses.
// A Vec3 is a position in mm, a direction, or linear rgb, as its name says.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

namespace lamella {

using Vec2 = cv::Vec2f;
using Vec3 = cv::Vec3f;
using Vec3d = cv::Vec3d;
using Mat33d = cv::Matx33d;
using Image1 = cv::Mat1f;  // rows x columns, one float
using Image2 = cv::Mat_<Vec2>;
using Image3 = cv::Mat_<Vec3>;  // rows x columns, rgb or xyz
using Mask = cv::Mat1b;         // 0 or 255
using Labels = cv::Mat1b;       // 0 is background

inline constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
inline constexpr float kPi = 3.14159265358979f;
inline constexpr std::array<const char*, 3> kChannelNames{"red", "green", "blue"};

inline float dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

inline float length(const Vec3& a) { return std::sqrt(dot(a, a)); }

// Zero stays zero.
inline Vec3 unit(const Vec3& a) {
  const float n = length(a);
  return n > 0.f ? a * (1.f / n) : a;
}

inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline float mean(const Vec3& a) { return (a[0] + a[1] + a[2]) / 3.f; }

inline bool is_finite(float a) { return std::isfinite(a); }

inline bool is_finite(const Vec3& a) {
  return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}

}  // namespace lamella
