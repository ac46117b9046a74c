#include "fit/gradient_inversion.h"

#include <gtest/gtest.h>

#include "fit/occlusion.h"
#include "fit/synthetic_rig.h"

namespace lamella::fit {
namespace {

std::vector<Vec3> some_normals() {
  return {unit(Vec3(0, 0, 1)), unit(Vec3(.5f, .2f, .8f)), unit(Vec3(-.9f, .1f, .4f)),
          unit(Vec3(.1f, -.95f, .1f)), unit(Vec3(.3f, .8f, .5f))};
}

TEST(GradientInversion, RecoversTheNormalFromTheSumOverTheLeds) {
  const LedsFrom leds(LightStage(testing::leds_all_around(150)), Vec3(0, 0, 0));
  for (const Vec3& n : some_normals()) {
    const Vec3 m = lambertian_mean_direction(leds, 1, n);
    EXPECT_LT(testing::angle_deg(invert_mean_direction(leds, 1, m, unit(m)), n), 0.1f);
  }
}

TEST(GradientInversion, KnowsThatNearAndUnevenLedsBendTheGradients) {
  std::vector<Led> lamps = testing::leds_all_around(120);
  for (size_t i = 0; i < lamps.size(); ++i) {
    lamps[i].distance_mm = 700;
    lamps[i].intensity = i % 3 ? Vec3(1, 1, 1) : Vec3(2, 1, .4f);
  }
  lamps.erase(lamps.begin(), lamps.begin() + 12);  // a gap around the cameras
  const LedsFrom leds(LightStage(lamps), Vec3(60, -80, 40));
  for (int c = 0; c < 3; ++c) {
    for (const Vec3& n : some_normals()) {
      const Vec3 m = lambertian_mean_direction(leds, c, n);
      EXPECT_LT(testing::angle_deg(invert_mean_direction(leds, c, m, unit(m)), n), 0.5f);
    }
  }
}

TEST(GradientInversion, OnAnEvenSphereTheMeanDirectionIsTwoThirdsOfTheNormal) {
  const LedsFrom leds(LightStage(testing::leds_all_around(4000)), Vec3(0, 0, 0));
  for (const Vec3& n : some_normals()) {
    EXPECT_LT(length(lambertian_mean_direction(leds, 0, n) - n * (2.f / 3)), 0.005f);
  }
}

TEST(GradientInversion, TurnsWithTheRig) {
  Session session = testing::make_session();
  const LedsFrom before(session.stage, Vec3(0, 0, 0));
  const Mat33d turn(0.36, 0.48, -0.8, -0.8, 0.6, 0, 0.48, 0.64, 0.6);
  testing::rotate_rig(turn, &session);
  const LedsFrom after(session.stage, Vec3(0, 0, 0));
  const Vec3 m(.3f, .2f, .5f), turned = cv::Matx33f(turn) * m;
  const Vec3 n = cv::Matx33f(turn) * invert_mean_direction(before, 0, m, unit(m));
  EXPECT_LT(testing::angle_deg(invert_mean_direction(after, 0, turned, unit(turned)), n), 0.01f);
}

TEST(GradientInversion, OfOneNormalIsThatOfEight) {
  const Session session = testing::make_session();
  const LedsFrom leds(session.stage, Vec3(12, -30, 25));
  const Vec3 m(.3f, .2f, .5f);
  const Vec3 one = invert_mean_direction(leds, 2, m, unit(m));
  const LaneVec3 lanes{Lanes{} + m[0], Lanes{} + m[1], Lanes{} + m[2]};
  const LaneNormals eight = invert_mean_direction(leds, 2, lanes, lanes);
  for (int k = 0; k < kLanes; ++k) {
    for (size_t a = 0; a < 3; ++a) EXPECT_NEAR(eight.normal[a][k], one[int(a)], 1e-5f);
  }
}

// Failure: on a fine camera a hundred times as many rays as shadows ask for.
TEST(Surroundings, NodesAreAsFarApartAsTheFaceAsksForNotThePixels) {
  Camera camera;
  camera.translation_mm = {0, 0, 1000};
  camera.fx = camera.fy = 4000;  // pixels of 0.25 mm
  EXPECT_EQ(Surroundings::step_for(camera), 6);
  camera.fx = camera.fy = 16000;
  EXPECT_EQ(Surroundings::step_for(camera), 24);
  camera.fx = camera.fy = 1000;
  EXPECT_EQ(Surroundings::step_for(camera), 6);
}

// One node whose LEDs with x > 0 are hidden by something black or something that shines.
struct HalfBlocked {
  LightStage stage{testing::leds_all_around(150)};
  Image3 position = Image3(1, 2, Vec3(0, 0, 0));
  cv::Mat_<DiffuseMoments> moments = cv::Mat_<DiffuseMoments>(1, 2, DiffuseMoments::all(0));
  Surroundings around = place_nodes(position, stage);

  void block(int32_t by) {
    for (size_t i = 0; i < around.leds; ++i) {
      if (stage.leds()[i].direction[0] > 0) around.blocker[i] = by;
    }
  }

  OcclusionAtNode occlusion(const Vec3& normal) const {
    return occlusion_at_nodes(around, stage, position, Image3(1, 2, normal), moments)[0];
  }

  // m of the light that reaches the node past what blocks it.
  Vec3 lit_direction(const Vec3& normal) const {
    Vec3 sum(0, 0, 0);
    float full = 0;
    for (const Led& led : stage.leds()) {
      const float gives = std::max(0.f, dot(normal, led.direction));
      if (led.direction[0] > 0) continue;
      sum += led.direction * gives;
      full += gives;
    }
    return sum * (1 / full);
  }
};

TEST(GradientInversion, RecoversTheNormalWithHalfTheLightBlocked) {
  HalfBlocked node;
  node.block(Surroundings::kUnknown);
  const LedsFrom leds(node.stage, Vec3(0, 0, 0));
  const Vec3 n = unit(Vec3(.2f, .3f, .9f));
  const OcclusionAtNode o = node.occlusion(n);
  const Vec3 free = node.lit_direction(n) - o.bend[1];
  EXPECT_GT(length(o.bend[1]), 0.2f);
  EXPECT_LT(testing::angle_deg(invert_mean_direction(leds, 1, free, unit(free)), n), 0.1f);
}

TEST(GradientInversion, ShareOfVisibleLightIsHalfBeforeAWall) {
  HalfBlocked node;
  node.block(Surroundings::kUnknown);
  EXPECT_NEAR(node.occlusion(Vec3(0, 0, 1)).ambient_visibility, 0.5f, 0.02f);
  node.block(Surroundings::kFree);
  EXPECT_FLOAT_EQ(node.occlusion(Vec3(0, 0, 1)).ambient_visibility, 1);
}

TEST(GradientInversion, AWallThatShinesAsTheLedsDoBendsHalfAsMuchAsABlackOne) {
  HalfBlocked node;
  node.block(1);
  // Radiance 1 all around shows a white surface 1, as all LEDs together do.
  for (int c = 0; c < 3; ++c) node.moments(0, 1)[4 * c] = 1;
  const Vec3 n(0, 0, 1);
  const Vec3 dark_bend = [&] {
    HalfBlocked dark;
    dark.block(Surroundings::kUnknown);
    return dark.occlusion(n).bend[0];
  }();
  // It gives the light that the hidden LEDs gave, but the same under every gradient.
  EXPECT_NEAR(node.occlusion(n).bend[0][0], dark_bend[0] / 2, 0.02f);
}

}  // namespace
}  // namespace lamella::fit
