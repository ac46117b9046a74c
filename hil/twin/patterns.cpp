#include "twin/patterns.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace lamella::twin {

namespace {

// Share of a pixel that lies outside a disc, by 4 x 4 samples; (du, dv) from the disc's centre to
// the pixel's.
float share_outside(double du, double dv, double radius) {
  const double distance = std::hypot(du, dv);
  if (distance > radius + 1) return 1.f;
  if (distance < radius - 1) return 0.f;
  int outside = 0;
  for (int i = 0; i < 16; ++i) {
    const double x = du + (i % 4 - 1.5) / 4.0, y = dv + (i / 4 - 1.5) / 4.0;
    if (std::hypot(x, y) >= radius) ++outside;
  }
  return float(outside) / 16.f;
}

}  // namespace

Image3 fringe_pattern(const Session& rig, int index) {
  const double periods = rig.patterns.fringe_periods.at(size_t(index));
  Image3 row(1, rig.projector.width);
  for (int u = 0; u < row.cols; ++u) {
    for (int c = 0; c < 3; ++c) {
      const double phase = 2 * CV_PI * (periods * u / row.cols + (c - 1) / 3.0);
      row(0, u)[c] = float(0.5 + 0.5 * std::cos(phase));
    }
  }
  return cv::repeat(row, rig.projector.height, 1);
}

Image3 stripe_pattern(const Session& rig, double shift_px) {
  const double period = rig.patterns.stripe_period_px;
  Image3 row(1, rig.projector.width);
  for (int u = 0; u < row.cols; ++u) {
    // `floor((u - shift) mod period) < period / 2`; shifts between pixels mix two neighbours.
    const double whole = std::floor(shift_px), part = shift_px - whole;
    const auto lit = [&](double at) {
      const double within = at - period * std::floor(at / period);
      return std::floor(within) < period / 2 ? 1.0 : 0.0;
    };
    const double value = (1 - part) * lit(u - whole) + part * lit(u - whole - 1);
    row(0, u) = Vec3::all(float(value));
  }
  return cv::repeat(row, rig.projector.height, 1);
}

Image3 dot_pattern(const Session& rig) {
  const Patterns& p = rig.patterns;
  const auto from_centre = [&](double x, double offset) {
    return x - offset - p.dot_pitch_px * std::round((x - offset) / p.dot_pitch_px);
  };
  Image3 image(rig.projector.height, rig.projector.width);
  for (int v = 0; v < image.rows; ++v) {
    const double dv = from_centre(v, p.dot_offset_px[1]);
    for (int u = 0; u < image.cols; ++u) {
      const double du = from_centre(u, p.dot_offset_px[0]);
      image(v, u) = Vec3::all(share_outside(du, dv, 0.5 * p.dot_diameter_px));
    }
  }
  return image;
}

Image3 even_pattern(const Session& rig, float value) {
  return Image3(rig.projector.height, rig.projector.width, Vec3::all(value));
}

Image3 emitted(const Image3& pattern) {
  Image3 blurred;
  cv::GaussianBlur(pattern, blurred, {}, kProjectorBlurPx, kProjectorBlurPx, cv::BORDER_REPLICATE);
  cv::Mat light;
  cv::Mat(blurred).convertTo(light, CV_32FC3, 1.0 - kProjectorBlack);
  return light + cv::Scalar::all(kProjectorBlack);
}

Vec3 sample_pattern(const Image3& pattern, const cv::Vec2d& uv) {
  if (!(uv[0] >= -0.5 && uv[1] >= -0.5 && uv[0] <= pattern.cols - 0.5 &&
        uv[1] <= pattern.rows - 0.5)) {
    return {0, 0, 0};
  }
  const float u = std::clamp(float(uv[0]), 0.f, float(pattern.cols - 1));
  const float v = std::clamp(float(uv[1]), 0.f, float(pattern.rows - 1));
  const int i = std::min(int(u), pattern.cols - 2), j = std::min(int(v), pattern.rows - 2);
  const float a = u - float(i), b = v - float(j);
  return (pattern(j, i) * (1 - a) + pattern(j, i + 1) * a) * (1 - b) +
         (pattern(j + 1, i) * (1 - a) + pattern(j + 1, i + 1) * a) * b;
}

}  // namespace lamella::twin
