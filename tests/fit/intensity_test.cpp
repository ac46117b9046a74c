#include "fit/intensity.h"

#include <gtest/gtest.h>

namespace lamella::fit {
namespace {

constexpr float kTrueC = 0.3f;

struct Skin {
  Burst burst;
  Responses responses;
  std::vector<RegionFit> fits{prior_region_fit()};
};

// One region whose lobe answers either light by 1, without single scattering.
Skin plain_skin() {
  Skin skin;
  const cv::Size size(40, 40);
  skin.burst.regions = Labels(size, uchar(1));
  skin.burst.clipped_led = skin.burst.clipped_projector = Mask(size, uchar(0));
  skin.burst.led_noise = skin.burst.projector_noise = {1e-7, 3e-5};
  for (AnalyserPair* pair : {&skin.burst.full, &skin.burst.front}) {
    pair->cross = Image3(size, Vec3::all(0.2f));
    pair->parallel = pair->cross + cv::Scalar::all(double(kTrueC));
  }
  for (Image1* map : {&skin.responses.led_lobe, &skin.responses.front_lobe,
                      &skin.responses.led_share}) {
    *map = Image1(size, 1.f);
  }
  for (Image1* map : {&skin.responses.led_single, &skin.responses.front_single,
                      &skin.responses.front_slope}) {
    *map = Image1(size, 0.f);
  }
  skin.fits[0].intensity = double(kTrueC);
  return skin;
}

TEST(Intensity, IsTheMeasuredLightOverTheLobes) {
  const Skin skin = plain_skin();
  const IntensityMap map = estimate_intensity(skin.burst, skin.responses, skin.fits);
  for (const float c : map.c) EXPECT_NEAR(c, kTrueC, 1e-4f);
}

// Failure: the quotient there is infinite, infinity times a weight of 0 is not a number, and the
// mean of every neighbourhood carries it over the whole map.
TEST(Intensity, APixelWhereTheLobeIsNextToNothingSpoilsNoOther) {
  Skin skin = plain_skin();
  skin.responses.front_lobe(20, 20) = skin.responses.led_lobe(20, 20) = 1e-40f;
  const IntensityMap map = estimate_intensity(skin.burst, skin.responses, skin.fits);
  for (int y = 0; y < map.c.rows; ++y) {
    for (int x = 0; x < map.c.cols; ++x) {
      EXPECT_NEAR(map.c(y, x), kTrueC, 1e-3f) << x << ", " << y;
      EXPECT_TRUE(std::isfinite(map.confidence(y, x))) << x << ", " << y;
    }
  }
}

}  // namespace
}  // namespace lamella::fit
