#include "render/lights.h"

#include <gtest/gtest.h>

#include "render/scene.h"

namespace lamella::render {
namespace {

Vec3 white_radiance(const std::vector<LightSample>& samples, const Vec3& normal) {
  Vec3 sum(0, 0, 0);
  for (const LightSample& s : samples) sum += s.strength * std::max(0.f, dot(s.place, normal));
  return sum;
}

TEST(Environment, OfRadianceOneLightsAWhiteSurfaceToOneWhereverItFaces) {
  const auto samples = cut_environment(Image3(64, 128, Vec3::all(1)), 400);
  for (const Vec3& n : {Vec3(0, 0, 1), Vec3(1, 0, 0), Vec3(0, -1, 0), unit(Vec3(1, 2, -3))}) {
    EXPECT_NEAR(white_radiance(samples, n)[1], 1, 0.01);
  }
}

TEST(Environment, KeepsAllItsLightHoweverFewCellsItIsCutInto) {
  Image3 map(32, 64);
  cv::randu(map, 0, 2);
  const auto total = [&](int cells) {
    Vec3 sum(0, 0, 0);
    for (const LightSample& s : cut_environment(map, cells)) sum += s.strength;
    return sum;
  };
  EXPECT_NEAR(total(50)[0], total(5000)[0], 1e-3);
  EXPECT_NEAR(total(50)[2], total(5000)[2], 1e-3);
}

TEST(Environment, HasItsCentreTowardsZItsTopTowardsYAndItsRightTowardsMinusX) {
  const auto only = [](int row, int col) {
    Image3 map(90, 180, Vec3(0, 0, 0));
    map(row, col) = Vec3::all(1);
    return cut_environment(map, 400).at(0).place;
  };
  EXPECT_GT(only(45, 90)[2], 0.999);
  EXPECT_GT(only(0, 90)[1], 0.999);
  EXPECT_LT(only(45, 135)[0], -0.999);
}

TEST(PointLight, HasItsRadianceAtTheOriginAndFallsWithTheSquareOfDistance) {
  const Camera camera = front_camera(8, 1);
  const Lights lights(lit_by(camera, point_light({0, 0, 500}, 2)), LightStage(), camera, 1);
  ASSERT_EQ(lights.size(), 1u);
  EXPECT_NEAR(lights.at(0, {0, 0, 0}).irradiance[0], 2, 1e-5);
  EXPECT_NEAR(lights.at(0, {0, 0, 250}).irradiance[0], 8, 1e-4);
  EXPECT_NEAR(lights.at(0, {0, 0, 250}).distance_mm, 250, 1e-3);
}

TEST(Projector, LightsOnlyWhatItsFrameCovers) {
  const Camera projector = front_camera(100, 1);
  Light light;
  light.kind = Light::Kind::kProjector;
  const Lights lights(lit_by(projector, light), LightStage(), projector, 1);
  EXPECT_NEAR(lights.at(0, {0, 0, 0}).irradiance[0], 1, 1e-5);
  EXPECT_EQ(lights.at(0, {60, 0, 0}).irradiance[0], 0);
  EXPECT_NEAR(lights.at(0, {0, 0, 100}).irradiance[0], 1 / 0.81, 1e-4);
}

TEST(Leds, OfTheWholeSphereShowAWhiteSurfaceAsOneFacingZ) {
  std::vector<Led> leds;
  for (int i = 0; i < 40; ++i) {
    Led led;
    led.direction = unit(Vec3(std::sin(i * 2.4f), std::cos(i * 2.4f), 1 - i / 20.f));
    led.distance_mm = i % 2 ? 900.f : 0.f;
    leds.push_back(led);
  }
  Light light;
  light.kind = Light::Kind::kLeds;
  light.weights.assign(leds.size(), 1.f);
  const Camera camera = front_camera(8, 1);
  const Lights lights(lit_by(camera, light), LightStage(leds), camera, 1);
  float sum = 0;
  for (size_t i = 0; i < lights.size(); ++i) {
    const Incident at = lights.at(i, {0, 0, 0});
    sum += at.irradiance[1] * std::max(0.f, at.direction[2]);
  }
  EXPECT_NEAR(sum, 1, 1e-4);
}

}  // namespace
}  // namespace lamella::render
