#include "fit/registration.h"

#include <gtest/gtest.h>

#include <random>

#include "skin_texture.h"

namespace lamella::fit {
namespace {

using testing::SkinPattern;

constexpr int kSide = 160;
constexpr double kDetailPx = 3;

Texture texture_at(const cv::Vec2d& moved_px, double slope, double noise) {
  const Image1 light = SkinPattern().photograph(cv::Size(kSide, kSide), moved_px);
  std::mt19937 random(7);
  std::normal_distribution<float> normal;
  Image1 shaded(light.size());
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double shade = 1 + slope * (double(x) / kSide - 0.5);
      shaded(y, x) = light(y, x) * float(shade) + float(noise) * normal(random);
    }
  }
  return texture_of(shaded, Mask(light.size(), 255), kDetailPx);
}

TEST(Shifted, ByNothingIsTheSame) {
  const Image1 image = SkinPattern().photograph(cv::Size(40, 30), {0, 0});
  EXPECT_EQ(cv::norm(Image1(shifted(image, {0, 0})), image, cv::NORM_INF), 0);
}

TEST(Shifted, ShowsAtAPixelWhatTheShiftAwayIs) {
  const cv::Vec2d by_px(0.37, -1.62);
  const Image1 found = shifted(SkinPattern().photograph(cv::Size(60, 60), {0, 0}), by_px);
  const Image1 true_one = SkinPattern().photograph(cv::Size(60, 60), -by_px);
  const cv::Rect inside(6, 6, 48, 48);
  EXPECT_LT(cv::norm(found(inside), true_one(inside), cv::NORM_INF), 2e-3);
}

TEST(ShiftedMask, KeepsEveryPixelThatTouchesAMaskedOne) {
  Mask mask(9, 9, uchar(0));
  mask(4, 4) = 255;
  const Mask found = shifted_mask(mask, {0.5, -0.5});
  EXPECT_EQ(cv::countNonZero(found), 4);
  EXPECT_EQ(found(4, 4), 255);
  EXPECT_EQ(found(5, 3), 255);
}

TEST(Registration, FindsAFractionOfAPixelUnderOtherShadingAndNoise) {
  const Registration r =
      register_textures(texture_at({0, 0}, 0, 2e-3), texture_at({0.63, -0.41}, 0.8, 2e-3));
  ASSERT_TRUE(r.is_found);
  EXPECT_NEAR(r.shift_px[0], 0.63, 0.02);
  EXPECT_NEAR(r.shift_px[1], -0.41, 0.02);
  EXPECT_LT(cv::norm(r.sigma_px), 0.05);
}

TEST(Registration, FindsShiftsOfManyPixels) {
  const Registration r = register_textures(texture_at({0, 0}, 0, 0), texture_at({5.3, 3.8}, 0, 0));
  ASSERT_TRUE(r.is_found);
  EXPECT_NEAR(r.shift_px[0], 5.3, 0.02);
  EXPECT_NEAR(r.shift_px[1], 3.8, 0.02);
}

TEST(Registration, SaysThatPhotographsOfOtherThingsHaveNothingInCommon) {
  const Image1 even(kSide, kSide, 0.3f);
  EXPECT_FALSE(register_textures(texture_at({0, 0}, 0, 0),
                                 texture_of(even, Mask(even.size(), 255), kDetailPx))
                   .is_found);
}

}  // namespace
}  // namespace lamella::fit
