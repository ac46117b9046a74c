#include "fit/pattern_extinction.h"

#include <gtest/gtest.h>

#include "lit_plane.h"

namespace lamella::fit {
namespace {

using testing::kHeight;
using testing::kWidth;
using testing::LitPlane;

constexpr float kExtinction = 0.03f, kPolarized = 0.4f, kBlackLevel = 0.04f;

// The format's own words: white where floor((u - k shift) mod period) < period / 2.
float stripe_lit(const Patterns& p, int k, double u) {
  const double turned = u - k * p.stripe_shift_px;
  const double in_period = turned - p.stripe_period_px * std::floor(turned / p.stripe_period_px);
  return std::floor(in_period) < p.stripe_period_px / 2 ? 1.f : 0.f;
}

// A plane of which every pixel also returns polarized light, of which a share leaks.
LitPlane leaking_plane() {
  LitPlane plane = testing::make_plane(Vec3(.3f, .2f, .15f), 2100);
  plane.session->left.extinction = double(kExtinction);
  Burst& burst = plane.burst;
  burst.black_level = kBlackLevel;
  burst.front.cross = burst.front_lit * (1 / (1 - kBlackLevel));
  burst.front.parallel = burst.front.cross + cv::Scalar::all(double(kPolarized));
  testing::photograph_stripes([](double) { return 0.0; }, &plane);
  burst.dots = burst.front_lit * 0.7f;
  return plane;
}

// Adds what leaks, and counts by how much each pixel is off once it has been removed.
template <class Light>
double share_left(const Image3& clean, const LitPlane& plane, Image3* leaking, const Light& light,
                  Burst* burst) {
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      // The projector's black shines too.
      const float emitted =
          kBlackLevel + (1 - kBlackLevel) * light(plane.geometry.projector_px(y, x));
      (*leaking)(y, x) += Vec3::all(kExtinction * kPolarized * emitted);
    }
  }
  remove_pattern_extinction(plane.geometry, burst);
  double left = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) left += std::abs((*leaking)(y, x)[1] - clean(y, x)[1]);
  }
  return left / (kHeight * kWidth) / double(kExtinction * kPolarized);
}

TEST(PatternExtinction, WhatLeaksUnderStripesIsTakenOut) {
  LitPlane plane = leaking_plane();
  Image3& stripes = plane.burst.stripes[3];
  const Image3 clean = stripes.clone();
  const auto light = [&](const Vec2& at) {
    return stripe_lit(plane.session->patterns, 3, double(at[0]));
  };
  // Pixels on an edge are half lit here and whole there.
  EXPECT_LT(share_left(clean, plane, &stripes, light, &plane.burst), 0.1);
}

TEST(PatternExtinction, WhatLeaksBetweenDotsIsTakenOut) {
  LitPlane plane = leaking_plane();
  const Image3 clean = plane.burst.dots.clone();
  const auto light = [&](const Vec2& at) {
    return testing::dot_lit(plane.session->patterns, double(at[0]), double(at[1]));
  };
  EXPECT_LT(share_left(clean, plane, &plane.burst.dots, light, &plane.burst), 0.05);
}

TEST(PatternExtinction, WhatTheProjectorsBlackLeaksInADotIsTakenOutToo) {
  LitPlane plane = leaking_plane();
  const Image3 clean = plane.burst.dots.clone();
  const Patterns& patterns = plane.session->patterns;
  const auto light = [&](const Vec2& at) { return dot_light(patterns, at[0], at[1]); };
  share_left(clean, plane, &plane.burst.dots, light, &plane.burst);
  int dark = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (light(plane.geometry.projector_px(y, x)) > 0) continue;
      ++dark;
      ASSERT_NEAR(plane.burst.dots(y, x)[1], clean(y, x)[1], 1e-6);
    }
  }
  EXPECT_GT(dark, 100);
}

TEST(PatternExtinction, APerfectAnalyserChangesNothing) {
  LitPlane plane = leaking_plane();
  plane.session->left.extinction = 0;
  const Image3 before = plane.burst.dots.clone();
  remove_pattern_extinction(plane.geometry, &plane.burst);
  EXPECT_EQ(cv::norm(before, plane.burst.dots), 0);
}

}  // namespace
}  // namespace lamella::fit
