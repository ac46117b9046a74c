#include <gtest/gtest.h>

#include "fit/led_irradiance.h"
#include "fit/scattering.h"
#include "lit_plane.h"

namespace lamella::fit {
namespace {

using testing::LitPlane;

Vec3 light_on(const LightStage& stage, const Vec3& n, const Vec3& x) {
  Vec3 sum(0, 0, 0);
  for (size_t i = 0; i < stage.leds().size(); ++i) {
    sum += stage.irradiance(i, x) * std::max(0.f, dot(n, stage.direction_from(i, x)));
  }
  return sum;
}

TEST(LedIrradiance, TableAgreesWithTheSumOverTheLeds) {
  const LightStage stage(testing::leds_all_around(150));
  const LedIrradiance table(stage, Vec3(-80, -100, -80), Vec3(80, 100, 80), 97);
  for (const Vec3& n : {Vec3(0, 0, 1), Vec3(.6f, 0, .8f), Vec3(-.8f, .6f, 0), Vec3(0, .6f, -.8f)}) {
    EXPECT_NEAR(table.at(n, {0, 0, 0})[1], light_on(stage, n, {0, 0, 0})[1], 0.01);
  }
}

TEST(LedIrradiance, NearLedsLightOneSideMoreThanTheOther) {
  std::vector<Led> leds = testing::leds_all_around(150);
  for (Led& led : leds) led.distance_mm = 900;
  const LightStage stage(leds);
  const LedIrradiance table(stage, Vec3(-80, -100, -80), Vec3(80, 100, 80), 97);
  const Vec3 n = unit({.3f, .1f, .9f});
  for (const Vec3& x : {Vec3(70, 0, 0), Vec3(-40, 60, 20)}) {
    EXPECT_NEAR(table.at(n, x)[0] / light_on(stage, n, x)[0], 1, 0.02);
  }
}

TEST(Albedo, OfAPlaneIsTwiceTheCrossedPhotographOverItsLight) {
  LitPlane plane = testing::make_plane(Vec3(.2f, .15f, .1f));
  const Albedo albedo = fit_albedo(plane.burst, plane.geometry, plane.normals);
  const float light = light_on(plane.session->stage, {0, 0, 1}, {0, 0, 0})[0];
  EXPECT_NEAR(albedo.total(50, 50)[0], 0.4f / light, 0.01);
}

TEST(Albedo, HalfHiddenSkinIsNotDarkerSkin) {
  LitPlane plane = testing::make_plane(Vec3(.2f, .15f, .1f));
  plane.burst.full.cross(50, 50) *= 0.5f;
  plane.normals.ambient_visibility(50, 50) = 0.5f;
  const Albedo albedo = fit_albedo(plane.burst, plane.geometry, plane.normals);
  EXPECT_NEAR(albedo.total(50, 50)[0], albedo.total(60, 60)[0], 1e-3);
  EXPECT_LT(albedo.confidence(50, 50), albedo.confidence(60, 60));
}

}  // namespace
}  // namespace lamella::fit
