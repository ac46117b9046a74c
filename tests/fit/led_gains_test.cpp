#include "fit/led_gains.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "synthetic_rig.h"

namespace lamella::fit {
namespace {

const LightStage& stage() {
  static const LightStage leds(testing::leds_all_around(150));
  return leds;
}

// m of a Lambertian surface under LEDs of these gains.
Vec3 mean_under(const Vec3& n, const std::function<double(const Vec3&)>& gain) {
  Vec3 sum(0, 0, 0);
  float full = 0;
  for (const Led& led : stage().leds()) {
    const float gives = std::max(0.f, dot(n, led.direction)) * float(gain(led.direction));
    full += gives;
    sum += led.direction * gives;
  }
  return sum * (1 / full);
}

double as_calibrated(const Vec3&) { return 1; }

// What the front of a sphere witnesses, with the noise of its normals.
std::vector<LedWitness> sphere(const std::function<Vec3(const Vec3&)>& measured) {
  std::mt19937 random(5);
  std::normal_distribution<float> noise(0, 0.004f);
  std::vector<LedWitness> witnesses;
  for (int j = -12; j <= 12; ++j) {
    for (int i = -12; i <= 12; ++i) {
      const float x = 0.05f * float(i), y = 0.05f * float(j);
      const Vec3 n(x, y, std::sqrt(1 - x * x - y * y));
      const Vec3 off = measured(n) - mean_under(n, as_calibrated);
      witnesses.push_back({n, off + Vec3(noise(random), noise(random), noise(random)),
                           ((i + 12) / 5 + (j + 12) / 5 * 5) % kWitnessGroups});
    }
  }
  return witnesses;
}

TEST(LedGains, OfAnAccurateCalibrationAreNothingAndMendNothing) {
  const LedGains gains = estimate_led_gains(
      stage(), sphere([](const Vec3& n) { return mean_under(n, as_calibrated); }));
  ASSERT_TRUE(gains.is_known);
  EXPECT_FALSE(gains.is_mended);
  for (size_t a = 0; a < 3; ++a) {
    EXPECT_LT(std::abs(gains.gradient[a]), 0.002);
    EXPECT_LT(gains.gradient_stddev[a], 0.005);
  }
  EXPECT_EQ(gains.mended_gain(1), 1.f);
}

TEST(LedGains, FindTheGradientThatIsTooBright) {
  const LedGains gains = estimate_led_gains(stage(), sphere([](const Vec3& n) {
                                              Vec3 m = mean_under(n, as_calibrated);
                                              m[1] = 1.04f * (1 + m[1]) - 1;
                                              return m;
                                            }));
  EXPECT_TRUE(gains.is_mended);
  EXPECT_NEAR(gains.gradient[1], 0.04, 0.003);
  EXPECT_NEAR(gains.gradient[0], 0, 0.003);
  EXPECT_NEAR(gains.mended_gain(1), 1.04f, 0.003f);
  EXPECT_EQ(gains.mended_gain(0), 1.f) << "within its sigmas";
}

TEST(LedGains, FindAnErrorThatVariesSlowlyOverTheSphere) {
  const LedGains gains = estimate_led_gains(
      stage(), sphere([](const Vec3& n) {
        return mean_under(n, [](const Vec3& w) { return 1 + 0.05 * w[0] - 0.04 * w[0] * w[1]; });
      }));
  EXPECT_NEAR(gains.low_order[0], 0.05, 0.01);
  EXPECT_NEAR(gains.low_order[3], -0.04, 0.01);
  for (size_t i = 0; i < LedGains::kOrders; ++i) {
    EXPECT_LT(gains.low_order_stddev[i], 0.04) << i;
    EXPECT_GT(gains.low_order_stddev[i], 0.02) << i;
  }
}

TEST(LedGains, AreNotKnownFromAFewPlacesAndSaySo) {
  std::vector<LedWitness> few = sphere([](const Vec3& n) { return mean_under(n, as_calibrated); });
  few.resize(100);
  const LedGains gains = estimate_led_gains(stage(), few);
  EXPECT_FALSE(gains.is_known);
  EXPECT_NE(gains.why.find("100 places"), std::string::npos) << gains.why;
}

}  // namespace
}  // namespace lamella::fit
