#include "fit/bled_light.h"

#include <gtest/gtest.h>

#include "fit/stereo.h"
#include "fit/synthetic_rig.h"

namespace lamella::fit {
namespace {

// A plane, of which a dim square is measured elsewhere: each of its columns lies so much further
// from the left camera than the one before.
class BledLight : public ::testing::Test {
 protected:
  BledLight() {
    for (int y = 0; y < size_.height; ++y) {
      for (int x = 0; x < size_.width; ++x) depth_.distance_mm(y, x) = plane_mm(y, x);
    }
  }

  float plane_mm(int y, int x) const {
    return float(-session_.left.centre_mm()[2] / session_.left.ray(x, y)[2]);
  }

  void tilt(float mm_per_px, float share) {
    share_(kDim).setTo(share);
    for (int x = kDim.x; x < kDim.br().x; ++x) {
      depth_.distance_mm.col(x).rowRange(kDim.y, kDim.br().y) += mm_per_px * float(x - kMiddle.x);
    }
  }

  void doubt() { doubt_bled_light(session_.left, session_.projector, share_, &depth_); }

  const cv::Rect kDim{60, 80, 20, 20};
  const cv::Point kMiddle{70, 90};
  const cv::Size size_{testing::kWidth, testing::kHeight};
  const Session session_ = testing::make_session();
  DepthMap depth_{Image1(size_),     Image1(size_, .02f), Image1(size_, 0.f), 1.25f, 3,
                  Image1(size_, .1f)};
  Image1 share_ = Image1(size_, 1.f);
};

TEST_F(BledLight, IsForgottenWhereTheSurfaceFacesAwayFromTheProjectorThatLightsIt) {
  tilt(-7, 0.3f);  // a sheet of light comes 1.25 mm / tan 10 degrees = 7.1 mm nearer a pixel
  doubt();
  EXPECT_TRUE(std::isnan(depth_.distance_mm(kMiddle)));
  EXPECT_FALSE(std::isnan(depth_.distance_mm(20, 20)));
}

TEST_F(BledLight, IsDoubtedWhereTheSurfaceIsDarkerThanItsSlope) {
  tilt(0, 0.3f);
  doubt();
  EXPECT_NEAR(depth_.distance_mm(kMiddle), plane_mm(kMiddle.y, kMiddle.x), 1e-3f);
  EXPECT_GT(depth_.bias_mm(kMiddle), 0.4f);
  EXPECT_FLOAT_EQ(depth_.bias_mm(20, 20), 0.1f);
}

TEST_F(BledLight, IsForgottenToWhereItsShadowEnds) {
  tilt(0, 0.3f);
  for (int x = kDim.x; x < kMiddle.x; ++x) {
    depth_.distance_mm.col(x).rowRange(kDim.y, kDim.br().y) -= 7 * float(x - kMiddle.x);
  }
  doubt();
  EXPECT_TRUE(std::isnan(depth_.distance_mm(90, 65)));
  EXPECT_TRUE(std::isnan(depth_.distance_mm(90, 71)));
  EXPECT_FALSE(std::isnan(depth_.distance_mm(90, 77)));
}

TEST_F(BledLight, IsNotSuspectedOnASlopeThatIsAsDimAsItShouldBe) {
  tilt(6, 0.3f);  // 68 degrees from the projector
  doubt();
  EXPECT_FALSE(std::isnan(depth_.distance_mm(kMiddle)));
  EXPECT_FLOAT_EQ(depth_.bias_mm(kMiddle), 0.1f);
}

TEST_F(BledLight, IsNotSuspectedForOnePixelOfNoise) {
  tilt(6, 0.3f);
  share_(kMiddle) = 0.1f;
  doubt();
  EXPECT_FLOAT_EQ(depth_.bias_mm(kMiddle), 0.1f);
}

TEST_F(BledLight, IsTooLittleToMatterWhereTheProjectorIsBright) {
  tilt(-7, 0.9f);
  doubt();
  EXPECT_FALSE(std::isnan(depth_.distance_mm(kMiddle)));
  EXPECT_FLOAT_EQ(depth_.bias_mm(kMiddle), 0.1f);
}

TEST_F(BledLight, MakesWhatOneCameraSaysAloneLessSure) {
  tilt(0, 0.3f);
  doubt();
  believe_alone(&depth_);
  EXPECT_NEAR(depth_.sigma_mm(20, 20), std::hypot(.02f, .1f), 1e-4f);
  EXPECT_NEAR(depth_.sigma_mm(kMiddle), std::hypot(.02f, .5f), 1e-4f);
}

TEST(ProjectorShare, KnowsAShadowFromDarkSkin) {
  Image3 front(40, 40, Vec3(.4f, .3f, .2f)), led(40, 40, Vec3(.8f, .6f, .4f));
  front(cv::Rect(0, 0, 8, 8)) *= 0.2;
  led(cv::Rect(0, 0, 8, 8)) *= 0.2;
  front(cv::Rect(20, 20, 8, 8)) *= 0.2;
  led(2, 35) = Vec3(0, 0, 0);
  const Image1 share = projector_share(front, led, Mask(40, 40, uchar(255)));
  EXPECT_NEAR(share(30, 5), 1, 1e-5f);
  EXPECT_NEAR(share(4, 4), 1, 1e-5f);
  EXPECT_NEAR(share(24, 24), 0.2f, 1e-5f);
  EXPECT_TRUE(is_finite(share(2, 35)));
}

}  // namespace
}  // namespace lamella::fit
