// Light on the surface and under it, on a smooth ball where the answers are known.
#include <gtest/gtest.h>

#include "twin/diffusion.h"
#include "twin/lighting.h"
#include "twin/rig.h"

namespace lamella::twin {
namespace {

constexpr float kRadius = 90.f;

// A ball of one skin without relief, facing +Z with `front`.
struct Ball {
  Subject subject;
  Surface surface;
  size_t front = 0;

  Ball() {
    subject.distance_mm = [](const Vec3& p) { return length(p) - kRadius; };
    subject.shading_normal = [](const Vec3&, const Vec3& n) { return n; };
    surface = make_surface(subject, 0.4f);
    for (size_t i = 0; i < surface.size(); ++i) {
      if (surface.position_mm[i][2] > surface.position_mm[front][2]) front = i;
    }
  }
};

const Ball& ball() {
  static const Ball made;
  return made;
}

// The same R(r) in every region: 0.3 exp(-r) / (2 pi), which integrates to 0.3 over the plane.
SkinProfiles exponential_skin() {
  Profile profile;
  for (int i = 0; i < Profile::kCount; ++i) {
    profile.deep[size_t(i)] = float(0.3 * std::exp(-Profile::radius_mm(i)) / (2 * kPi));
  }
  profile.deep_total = 0.3;
  SkinProfiles profiles;
  for (auto& region : profiles) region.fill(profile);
  return profiles;
}

ScatterTargets targets_at(const std::vector<Vec3>& places) {
  ScatterTargets targets;
  for (const Vec3& place : places) {
    targets.blocks.push_back({int(targets.position_mm.size())});
    targets.position_mm.push_back(place);
    targets.regions.push_back({1, 0, 0, 0, 0, 0});
  }
  return targets;
}

Vec3 on_ball(float arc_mm) {
  const float a = arc_mm / kRadius;
  return Vec3(std::sin(a), 0, std::cos(a)) * kRadius;
}

TEST(Surface, OfABallHasItsPlaceNormalsAndArea) {
  const Surface& s = ball().surface;
  double area = 0;
  for (size_t i = 0; i < s.size(); ++i) {
    ASSERT_NEAR(length(s.position_mm[i]), kRadius, 0.01f);
    if (s.position_mm[i][2] > 0) {
      ASSERT_GT(dot(s.normal[i], unit(s.position_mm[i])), 0.999f);
    }
    area += s.area_mm2[i];
  }
  EXPECT_NEAR(area, 4 * kPi * kRadius * kRadius, 0.01 * 4 * kPi * kRadius * kRadius);
}

TEST(LedLight, IsOneOnAWhitePatchThatFacesTheFront) {
  const Session rig = make_rig("ball", 0.2);
  const LedVisibility visibility(ball().surface, rig.stage.leds());
  const auto full =
      led_irradiance(ball().surface, visibility, rig.stage, std::vector<float>(kLedCount, 1.f));
  EXPECT_NEAR(full[ball().front][0], 1.f, 5e-3f);
  const auto half =
      led_irradiance(ball().surface, visibility, rig.stage, std::vector<float>(kLedCount, 0.5f));
  EXPECT_NEAR(half[ball().front][0], 0.5f * full[ball().front][0], 1e-6f);
}

TEST(PointLight, FallsWithTheSquareOfTheDistanceAndCastsShadows) {
  const PointLight light(ball().surface, {0, 0, 1000});
  EXPECT_FLOAT_EQ(light.strength({0, 0, 0}), 1.f);
  EXPECT_NEAR(light.vertex_irradiance()[ball().front], std::pow(1000.f / 910.f, 2.f), 1e-3f);
  EXPECT_TRUE(light.sees({0, 0, kRadius}, {0, 0, 1}));
  EXPECT_FALSE(light.sees({0, 0, -kRadius}, {0, 0, 1}));
}

TEST(Diffusion, OfEvenLightIsTheDiffuseReflectance) {
  const Diffusion diffusion(ball().surface, exponential_skin());
  const PatchLight even =
      gather_light(diffusion.tree(), std::vector<Vec3>(ball().surface.size(), Vec3(1, 2, 0)));
  const auto d = diffusion.scatter(targets_at({on_ball(0), on_ball(31.3f)}), {&even});
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(d[0][i][0], 0.3f, 1e-4f);
    EXPECT_NEAR(d[0][i][1], 0.6f, 2e-4f);
    EXPECT_EQ(d[0][i][2], 0.f);
  }
}

// Depolarized light at the front where light falls on `lit(distance from the front)`.
template <class Lit>
float at_the_front(const Lit& lit) {
  const Diffusion diffusion(ball().surface, exponential_skin());
  const Vec3 front = ball().surface.position_mm[ball().front];
  std::vector<Vec3> irradiance(ball().surface.size());
  for (size_t i = 0; i < irradiance.size(); ++i) {
    irradiance[i] = Vec3::all(float(lit(length(ball().surface.position_mm[i] - front))));
  }
  const PatchLight light = gather_light(diffusion.tree(), irradiance);
  return diffusion.scatter(targets_at({front}), {&light})[0][0][0];
}

TEST(Diffusion, OfASpotIsItsConvolutionWithTheProfile) {
  for (float width : {1.5f, 3.f}) {
    const auto spot = [&](float r) { return std::exp(-r * r / (2 * width * width)); };
    double expected = 0;  // integral of R(r) spot(r) over the plane
    for (float r = 0.005f; r < 16; r += 0.01f) expected += 0.3 * r * std::exp(-r) * spot(r) * 0.01;
    EXPECT_NEAR(at_the_front(spot), expected, 0.03 * expected) << width;
  }
}

TEST(Diffusion, ReachesTheMiddleOfADarkDotAsTheProfileSays) {
  const float dark_mm = 3.f;
  const double beyond = 0.3 * (1 + dark_mm) * std::exp(-dark_mm);
  EXPECT_NEAR(at_the_front([&](float r) { return r > dark_mm ? 1.f : 0.f; }), beyond,
              0.08 * beyond);
}

TEST(Diffusion, OfSeveralLightsAtOnceIsThatOfEachAlone) {
  const Diffusion diffusion(ball().surface, exponential_skin());
  std::vector<PatchLight> lights;
  for (int k = 0; k < 5; ++k) {
    std::vector<Vec3> irradiance(ball().surface.size());
    for (size_t i = 0; i < irradiance.size(); ++i) {
      irradiance[i] =
          Vec3::all(0.5f + 0.5f * std::cos(ball().surface.position_mm[i][0] + float(k)));
    }
    lights.push_back(gather_light(diffusion.tree(), irradiance));
  }
  const ScatterTargets targets = targets_at({on_ball(3.1f)});
  const auto together =
      diffusion.scatter(targets, {&lights[0], &lights[1], &lights[2], &lights[3], &lights[4]});
  for (size_t k = 0; k < 5; ++k) {
    const auto alone = diffusion.scatter(targets, {&lights[k]});
    EXPECT_NEAR(together[k][0][0], alone[0][0][0], 1e-6f);
  }
}

}  // namespace
}  // namespace lamella::twin
