#include "twin/rig.h"

#include <gtest/gtest.h>

#include <fstream>

#include "twin/patterns.h"

namespace lamella::twin {
namespace {

TEST(Leds, AreThe150OfTheProtocolInItsOrder) {
  const std::vector<Vec3> leds = led_directions();
  ASSERT_EQ(leds.size(), size_t(kLedCount));
  EXPECT_NEAR(length(leds[0] - Vec3(0, 1, 0)), 0, 1e-4);
  EXPECT_NEAR(length(leds[1] - Vec3(-0.147621f, 0.967949f, -0.203183f)), 0, 1e-4);
  for (size_t i = 1; i < leds.size(); ++i) EXPECT_LE(leds[i][1], leds[i - 1][1] + 1e-4f);
}

TEST(Leds, StandWhereTheFirmwaresListHasThem) {
  const fs::path file = fs::path(LAMELLA_BOARD_DIR) / "dome150.leds";
  std::ifstream rig(file);
  ASSERT_TRUE(rig) << file;
  const std::vector<Vec3> leds = led_directions();
  int found = 0;
  for (std::string line; std::getline(rig, line);) {
    int index, chip, output;
    Vec3 w;
    if (std::sscanf(line.c_str(), "led.%d = %d %d %f %f %f", &index, &chip, &output, &w[0], &w[1],
                    &w[2]) != 6) {
      continue;
    }
    ASSERT_LT(size_t(index), leds.size());
    EXPECT_NEAR(length(leds[size_t(index)] - w), 0, 1e-4) << line;
    ++found;
  }
  EXPECT_EQ(found, kLedCount);
}

TEST(Rig, LooksAtTheOriginFromTenDegreesToEachSide) {
  const Session rig = make_rig("head", 1.0);
  const cv::Vec2d centre = rig.left.project({0, 0, 0});
  EXPECT_NEAR(centre[0], rig.left.cx, 1e-9);
  EXPECT_NEAR(rig.left.centre_mm()[0], -1000 * std::sin(10 * CV_PI / 180), 1e-6);
  EXPECT_NEAR(rig.right->centre_mm()[0], 1000 * std::sin(10 * CV_PI / 180), 1e-6);
  EXPECT_GT(cv::norm(rig.projector_to_led - Mat33d::eye()), 0.05);
}

TEST(Rig, IsWhiteUnderItsOwnLightsInTheUnitsOfASession) {
  const Session rig = make_rig("head", 1.0);
  float leds = 0;
  for (size_t i = 0; i < rig.stage.leds().size(); ++i) {
    leds += rig.stage.irradiance(i, {0, 0, 0})[1] * std::max(0.f, rig.stage.leds()[i].direction[2]);
  }
  EXPECT_NEAR(leds, 1.f, 1e-5f);
  EXPECT_FLOAT_EQ(projector_irradiance(rig.projector, {0, 0, 0}), 1.f);
}

TEST(Stripes, AreWhiteInTheFirstHalfOfEachPeriodAndMoveByTheShift) {
  const Session rig = make_rig("head", 0.2);
  const Image3 still = stripe_pattern(rig, 0), moved = stripe_pattern(rig, 2);
  for (int u = 0; u < 16; ++u) EXPECT_EQ(still(5, u)[0], u % 8 < 4 ? 1.f : 0.f) << u;
  for (int u = 2; u < 16; ++u) EXPECT_EQ(moved(5, u)[0], still(5, u - 2)[0]) << u;
}

TEST(Stripes, ThatMoveHalfAPixelAreTheMeanOfTheirNeighbours) {
  const Session rig = make_rig("head", 0.2);
  const Image3 half = stripe_pattern(rig, 0.5);
  const Image3 a = stripe_pattern(rig, 0), b = stripe_pattern(rig, 1);
  for (int u = 0; u < 16; ++u) EXPECT_FLOAT_EQ(half(0, u)[1], (a(0, u)[1] + b(0, u)[1]) / 2) << u;
}

TEST(Dots, AreDarkInsideTheirDiametersAndWhiteBetween) {
  const Session rig = make_rig("head", 0.2);
  const Image3 dots = dot_pattern(rig);
  EXPECT_EQ(dots(400, 640)[0], 0.f);
  EXPECT_EQ(dots(400, 640 + 8)[0], 0.f);
  EXPECT_EQ(dots(400, 640 + 12)[0], 1.f);
  EXPECT_EQ(dots(400, 640 + 53)[0], 0.f);
}

TEST(Fringes, AreColouredCosines) {
  const Session rig = make_rig("head", 0.2);
  const Image3 fringe = fringe_pattern(rig, 1);
  for (int c = 0; c < 3; ++c) {
    const double phase = 2 * CV_PI * (4.0 * 100 / 1280 + (c - 1) / 3.0);
    EXPECT_NEAR(fringe(7, 100)[c], 0.5 + 0.5 * std::cos(phase), 1e-6);
  }
}

TEST(Projector, NeverEmitsLessThanItsBlackOrMoreThanOne) {
  const Session rig = make_rig("head", 0.2);
  EXPECT_NEAR(emitted(even_pattern(rig, 0))(9, 9)[0], kProjectorBlack, 1e-6);
  EXPECT_NEAR(emitted(even_pattern(rig, 1))(9, 9)[0], 1.f, 1e-6);
  EXPECT_EQ(sample_pattern(even_pattern(rig, 1), {-3, 10})[0], 0.f);
}

TEST(Rig, StatesTheNoiseThatItsSensorsHave) {
  const Session quiet = make_rig("head", 0.2), noisy = make_rig("head", 0.2, 3);
  EXPECT_DOUBLE_EQ(noisy.left.read_noise, 3 * quiet.left.read_noise);
  EXPECT_DOUBLE_EQ(noisy.right->full_well_electrons, quiet.right->full_well_electrons / 9);
  EXPECT_EQ(make_rig("head", 0.2, 0).left.full_well_electrons, 0);
}

}  // namespace
}  // namespace lamella::twin
