#include "base/light_stage.h"

#include <gtest/gtest.h>

namespace lamella {
namespace {

std::vector<Led> uneven_leds() {
  return {{unit({0.f, 0.f, 1.f}), 0, {1, 1, 1}},
          {unit({1.f, 0.2f, 0.5f}), 0, {2, 1, 0.5f}},
          {unit({-0.3f, 0.9f, 0.1f}), 800, {1, 1.5f, 1}},
          {unit({0.f, 0.f, -1.f}), 0, {3, 3, 3}}};
}

// Radiance of the white Lambertian surface at the origin with normal n, every LED at 1.
Vec3 white_radiance(const LightStage& stage, const Vec3& n) {
  Vec3 sum(0, 0, 0);
  const Vec3 origin(0, 0, 0);
  for (size_t i = 0; i < stage.leds().size(); ++i) {
    sum += stage.irradiance(i, origin) * std::max(0.f, dot(n, stage.direction_from(i, origin)));
  }
  return sum;
}

TEST(LightStage, LightsAWhiteSurfaceThatFacesTheCamerasToOne) {
  const Vec3 white = white_radiance(LightStage(uneven_leds()), {0, 0, 1});
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(white[c], 1, 1e-6);
}

TEST(LightStage, LightsFromBehindOnlyWhatFacesBack) {
  const LightStage stage(uneven_leds());
  EXPECT_EQ(stage.irradiance(3, {0, 0, 0})[0], 3 * stage.irradiance(0, {0, 0, 0})[0]);
}

TEST(LightStage, FallsWithTheSquareOfTheDistanceOfANearLedAndNotOfAFarOne) {
  const LightStage stage(uneven_leds());
  const Vec3 half_way = stage.leds()[2].direction * 400.f;
  EXPECT_NEAR(stage.irradiance(2, half_way)[1] / stage.irradiance(2, {0, 0, 0})[1], 4, 1e-4);
  EXPECT_EQ(stage.irradiance(0, half_way), stage.irradiance(0, {0, 0, 0}));
}

TEST(LightStage, SeesANearLedInAnotherDirectionFromAnotherPlace) {
  const LightStage stage(uneven_leds());
  const Vec3 x(50, 0, 0);
  const Vec3 expected = unit(stage.leds()[2].direction * 800.f - x);
  EXPECT_LT(length(stage.direction_from(2, x) - expected), 1e-6f);
  EXPECT_EQ(stage.direction_from(0, x), stage.leds()[0].direction);
}

TEST(LightStage, WithoutLedsLightsNothing) {
  EXPECT_EQ(white_radiance(LightStage(), {0, 0, 1}), Vec3(0, 0, 0));
}

TEST(GradientLevel, RunsFromNothingToAllAlongItsAxis) {
  EXPECT_EQ(gradient_level({0, 1, 0}, 1), 1.f);
  EXPECT_EQ(gradient_level({0, -1, 0}, 1), 0.f);
  EXPECT_EQ(gradient_level({1, 0, 0}, 1), 0.5f);
}

TEST(ProjectorIrradiance, IsOneAtTheOriginAndFallsWithTheSquare) {
  Camera projector;
  projector.cam_from_rig = Mat33d(1, 0, 0, 0, -1, 0, 0, 0, -1);
  projector.translation_mm = {0, 0, 1000};
  EXPECT_FLOAT_EQ(projector_irradiance(projector, {0, 0, 0}), 1.f);
  EXPECT_FLOAT_EQ(projector_irradiance(projector, {0, 0, 500}), 4.f);
}

}  // namespace
}  // namespace lamella
