#include "calib/develop.h"

#include <gtest/gtest.h>
#include <opencv2/core/cvdef.h>

#include "io/raw12.h"

namespace lamella {
namespace {

Image3 developed(uint16_t dn, const RawFormat& format) {
  RawImage raw(2, 2, cv::Vec3w(dn, dn, dn));
  return develop(pack_rgb12p(raw), raw.size(), format);
}

TEST(Develop, TakesOffTheBlackLevelAndAppliesTheGain) {
  const RawFormat format{64, 1.0 / 4000, 1.0};
  EXPECT_FLOAT_EQ(developed(64, format)(1, 1)[0], 0.f);
  EXPECT_FLOAT_EQ(developed(2064, format)(1, 1)[2], 0.5f);
}

TEST(Develop, LeavesNoiseBelowBlackNegativeSoThatItAveragesToZero) {
  EXPECT_FLOAT_EQ(developed(60, {64, 0.001, 1.0})(0, 0)[1], -0.004f);
}

// 0.98 has no half of its own: the nearest is below it and would pass for a measurement.
TEST(Develop, KeepsAClippedValueClippedWhenItIsRoundedToHalf) {
  for (double saturation : {0.98, 1.0, 0.3333, 3.97}) {
    const RawFormat format{64, saturation / (4095 - 64), saturation};
    const float stored = developed(4095, format)(0, 0)[0];
    EXPECT_GE(float(cv::float16_t(stored)), float(saturation)) << saturation;
    EXPECT_LT(stored, saturation * 1.002) << saturation;
  }
}

TEST(Develop, CallsFullScaleClippedWhateverTheGainMakesOfIt) {
  EXPECT_GE(developed(4095, {64, 0.0001, 1.0})(0, 0)[0], 1.f);
  EXPECT_LT(developed(4094, {64, 0.0001, 1.0})(0, 0)[0], 1.f);
}

TEST(Develop, GivesNothingForBytesOfAnotherSize) {
  EXPECT_TRUE(develop(std::vector<uint8_t>(17), {2, 2}, {}).empty());
}

}  // namespace
}  // namespace lamella
