// A plane of known skin under the projector's patterns, by brute force: every photographed point
// sums the light of the lit points around it.
#pragma once

#include <functional>
#include <memory>
#include <random>

#include "fit/normals.h"
#include "synthetic_rig.h"

namespace lamella::fit::testing {

struct LitPlane {
  std::unique_ptr<Session> session;
  Burst burst;
  Geometry geometry;
  Normals normals;
};

using RadialKernel = std::function<double(double)>;  // per mm^2, at r mm

// Points and weights of a polar rule about the origin, kernel included; weights sum to 1.
inline std::vector<std::pair<Vec2, double>> spread(const RadialKernel& kernel) {
  constexpr int kRings = 40, kSpokes = 24;
  std::vector<std::pair<Vec2, double>> points;
  double sum = 0;
  const double ratio = std::pow(16 / 0.005, 1.0 / kRings);
  for (int i = 0; i < kRings; ++i) {
    const double r = 0.005 * std::pow(ratio, i + 0.5), ring = 2 * M_PI * r * r * std::log(ratio);
    for (int k = 0; k < kSpokes; ++k) {
      const double angle = 2 * M_PI * (k + 0.5 * (i & 1)) / kSpokes, w = ring * kernel(r) / kSpokes;
      points.push_back({Vec2(float(r * std::cos(angle)), float(r * std::sin(angle))), w});
      sum += w;
    }
  }
  for (auto& point : points) point.second /= sum;
  return points;
}

inline float dot_lit(const Patterns& patterns, double u, double v) {
  const double pitch = patterns.dot_pitch_px, radius = 0.5 * patterns.dot_diameter_px;
  const double a = (u - patterns.dot_offset_px[0]) / pitch;
  const double b = (v - patterns.dot_offset_px[1]) / pitch;
  const double x = pitch * (a - std::floor(a + 0.5)), y = pitch * (b - std::floor(b + 0.5));
  return x * x + y * y < radius * radius ? 0.f : 1.f;
}

// The plane z = 0, seen as by a camera of `fx`; every pixel is label 1. `white`: FRONT - BLACK.
inline LitPlane make_plane(const Vec3& white, double fx = 2600) {
  LitPlane plane;
  plane.session = std::make_unique<Session>(make_session());
  Session& session = *plane.session;
  session.left = camera_at(0, 1000, fx);
  Burst& burst = plane.burst;
  burst.session = plane.session.get();
  burst.region_names = session.region_names;
  burst.regions = Labels(kHeight, kWidth, uchar(1));
  burst.clipped_projector = Mask(kHeight, kWidth, uchar(0));
  burst.front_lit = Image3(kHeight, kWidth, white);
  burst.full.cross = Image3(kHeight, kWidth, white);
  Geometry& g = plane.geometry;
  const cv::Size size(kWidth, kHeight);
  g.position_mm = g.to_projector = g.to_camera = Image3(size, Vec3(0, 0, 1));
  g.position_mm = g.position_mm.clone();
  g.projector_px = Image2(size, Vec2(0, 0));
  g.projector_irradiance = Image1(size, 1.f);
  plane.normals.specular = Image3(size, Vec3(0, 0, 1));
  for (Image3& n : plane.normals.diffuse) n = plane.normals.specular;
  plane.normals.ambient_visibility = Image1(size, 1.f);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Vec3d ray = session.left.ray(x, y), o = session.left.centre_mm();
      const Vec3d p = o - ray * (o[2] / ray[2]);
      g.position_mm(y, x) = Vec3(p);
      g.projector_px(y, x) = Vec2(session.projector.project(p));
    }
  }
  return plane;
}

// DOTS - BLACK of skin that scatters by `kernels` (one a channel).
inline void photograph_dots(const std::array<RadialKernel, 3>& kernels, LitPlane* plane) {
  const Session& session = *plane->session;
  const double px_per_mm = session.projector.fx / 1000;
  plane->burst.dots = Image3(kHeight, kWidth, Vec3(0, 0, 0));
  for (int c = 0; c < 3; ++c) {
    const auto points = spread(kernels[size_t(c)]);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const Vec2 at = plane->geometry.projector_px(y, x);
        double share = 0;
        for (const auto& [offset, weight] : points) {
          share += weight * double(dot_lit(session.patterns, at[0] + px_per_mm * offset[0],
                                           at[1] + px_per_mm * offset[1]));
        }
        plane->burst.dots(y, x)[c] = plane->burst.front_lit(y, x)[c] * float(share);
      }
    }
  }
}

// `transfer`: what skin leaves of a wave of f cycles per mm.
inline void photograph_stripes(const std::function<double(double)>& transfer, LitPlane* plane) {
  const Patterns& patterns = plane->session->patterns;
  const double cycles_per_mm = plane->session->projector.fx / 1000 / patterns.stripe_period_px;
  for (int k = 0; k < 4; ++k) {
    Image3& image = plane->burst.stripes[size_t(k)];
    image = plane->burst.front_lit.clone();
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const double u = plane->geometry.projector_px(y, x)[0] - k * patterns.stripe_shift_px;
        double value = 0.5;
        for (int h = 1; h < 200; h += 2) {
          value += 2 / (M_PI * h) * transfer(h * cycles_per_mm) *
                   std::sin(2 * M_PI * h * u / patterns.stripe_period_px);
        }
        image(y, x) *= float(value);
      }
    }
  }
}

inline void add_noise(double sigma, Image3* image) {
  std::mt19937 random(7);
  std::normal_distribution<float> noise(0.f, float(sigma));
  for (Vec3& pixel : *image) {
    for (int c = 0; c < 3; ++c) pixel[c] += noise(random);
  }
}

}  // namespace lamella::fit::testing
