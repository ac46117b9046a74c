#include "base/rim.h"

#include <gtest/gtest.h>

#include "base/outline.h"

namespace lamella {
namespace {

constexpr int kPicture = 200;
constexpr float kRadiusPx = 80;

// A disc whose last three pixels each end at another depth.
Image3 spiky_disc(Image1* inside_px) {
  Mask disc(kPicture, kPicture, uchar(0));
  Image3 position_mm(kPicture, kPicture);
  for (int y = 0; y < kPicture; ++y) {
    for (int x = 0; x < kPicture; ++x) {
      const float r = std::hypot(float(x - kPicture / 2), float(y - kPicture / 2));
      disc(y, x) = r < kRadiusPx ? 255 : 0;
      position_mm(y, x) = {float(x), float(-y), 0};
      if (r > kRadiusPx - 3) position_mm(y, x)[2] = (x + y) % 2 ? 6.f : -6.f;
    }
  }
  *inside_px = signed_distance_px(disc);
  return position_mm;
}

TEST(Rim, LosesItsSpikesAndLeavesTheInsideAlone) {
  Image1 inside_px;
  const Image3 before = spiky_disc(&inside_px);
  Image3 position_mm = before.clone();
  smooth_along_rim(inside_px, &position_mm);
  double squares = 0;
  int count = 0;
  for (int y = 0; y < kPicture; ++y) {
    for (int x = 0; x < kPicture; ++x) {
      if (inside_px(y, x) > 10) {
        EXPECT_EQ(position_mm(y, x), before(y, x));
      }
      if (inside_px(y, x) < 0.5f || inside_px(y, x) > 1.5f) continue;
      squares += double(position_mm(y, x)[2]) * double(position_mm(y, x)[2]);
      ++count;
    }
  }
  EXPECT_LT(std::sqrt(squares / count), 4.);  // of 6 mm
}

TEST(Closed, FillsANotchButNotTheGapToTheBorderOfThePicture) {
  Mask mask(60, 60, uchar(0));
  mask(cv::Rect(3, 3, 54, 54)).setTo(255);
  mask(cv::Rect(3, 28, 20, 4)).setTo(0);
  const Mask whole = closed(mask, 5);
  EXPECT_EQ(whole(30, 15), 255);
  EXPECT_EQ(whole(15, 1), 0);
}

}  // namespace
}  // namespace lamella
