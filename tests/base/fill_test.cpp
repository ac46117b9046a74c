#include "base/fill.h"

#include <gtest/gtest.h>

namespace lamella {
namespace {

TEST(FillUnknown, KeepsKnownPixelsAndContinuesARamp) {
  Image1 ramp(64, 48);
  for (int y = 0; y < ramp.rows; ++y) {
    for (int x = 0; x < ramp.cols; ++x) ramp(y, x) = float(x);
  }
  Image1 torn = ramp.clone();
  torn(cv::Rect(20, 20, 9, 9)).setTo(kNaN);
  const Image1 filled = fill_unknown(torn);
  EXPECT_EQ(cv::countNonZero((filled != ramp) & (torn == torn)), 0);
  for (int y = 20; y < 29; ++y) {
    for (int x = 20; x < 29; ++x) EXPECT_NEAR(filled(y, x), ramp(y, x), 2.5f);
  }
}

TEST(FillUnknown, ReachesTheFarCornerFromOnePixel) {
  Image3 image(37, 53, Vec3(kNaN, kNaN, kNaN));
  image(3, 5) = {1, 2, 3};
  EXPECT_NEAR(length(fill_unknown(image)(36, 52) - Vec3(1, 2, 3)), 0.f, 1e-5f);
}

TEST(FillUnknown, OfNothingKnownIsZero) {
  const Image1 filled = fill_unknown(Image1(8, 8, kNaN));
  EXPECT_EQ(cv::countNonZero(filled), 0);
}

}  // namespace
}  // namespace lamella
