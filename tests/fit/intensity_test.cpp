#include "fit/intensity.h"

#include <gtest/gtest.h>

#include <cstring>
#include <opencv2/core.hpp>

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
  skin.burst.led_parallel_noise = skin.burst.front_parallel_noise = skin.burst.led_noise;
  for (AnalyserPair* pair : {&skin.burst.full, &skin.burst.front}) {
    pair->cross = Image3(size, Vec3::all(0.2f));
    pair->parallel = pair->cross + cv::Scalar::all(double(kTrueC));
  }
  for (Image1* map :
       {&skin.responses.led_lobe, &skin.responses.front_lobe, &skin.responses.led_share}) {
    *map = Image1(size, 1.f);
  }
  for (Image1* map : {&skin.responses.led_single, &skin.responses.front_single,
                      &skin.responses.front_slope, &skin.responses.led_slope}) {
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

TEST(Intensity, WhereNoSurfaceIsKnownItIsNobodys) {
  Skin skin = plain_skin();
  skin.responses.led_lobe(20, 20) = kNaN;
  const IntensityMap map = estimate_intensity(skin.burst, skin.responses, skin.fits);
  EXPECT_TRUE(std::isnan(map.c(20, 20)));
  EXPECT_EQ(map.confidence(20, 20), 0);
  EXPECT_TRUE(std::isfinite(map.c(20, 21)));
}

constexpr int kSide_px = 64;

Image3 noise3(float low, float high) {
  Image3 image(kSide_px, kSide_px);
  cv::randu(image, cv::Scalar::all(double(low)), cv::Scalar::all(double(high)));
  return image;
}

Image1 noise1(float low, float high) {
  Image1 image(kSide_px, kSide_px);
  cv::randu(image, double(low), double(high));
  return image;
}

Burst noisy_burst() {
  Burst burst;
  burst.regions = Labels(kSide_px, kSide_px, uchar(1));
  burst.region_names = {"background", "skin"};
  burst.led_noise = burst.projector_noise = {1e-5, 1e-4};
  burst.led_parallel_noise = burst.front_parallel_noise = burst.led_noise;
  burst.clipped_led = burst.clipped_projector = Mask(kSide_px, kSide_px, uchar(0));
  burst.full = {noise3(0.4f, 0.6f), noise3(0.2f, 0.3f)};
  burst.front = {noise3(0.4f, 0.6f), noise3(0.2f, 0.3f)};
  return burst;
}

// A row taken alone and a row among many run the same instructions, multiplications and additions
// contracted in the same way.
TEST(Intensity, IsTheSameToTheLastBitWhicheverThreadTakesARow) {
  cv::theRNG().state = 1;
  const Burst burst = noisy_burst();
  const Responses responses{noise1(0.5f, 1.f), noise1(0.5f, 1.f), noise1(0.5f, 1.f),
                            noise1(0.5f, 1.f), noise1(0.5f, 1.f), noise1(0.f, 3.f),
                            noise1(0.f, 3.f)};
  RegionFit fit = prior_region_fit();
  fit.intensity = 0.3;
  fit.single.amplitude = {0.067, 0.063, 0.053};
  const Image1 first = estimate_intensity(burst, responses, {fit}).c.clone();
  int other_rows = 0;
  for (int i = 0; i < 1000; ++i) {
    const Image1 again = estimate_intensity(burst, responses, {fit}).c;
    for (int y = 0; y < kSide_px; ++y) {
      other_rows += std::memcmp(first[y], again[y], kSide_px * sizeof(float)) != 0;
    }
  }
  EXPECT_EQ(other_rows, 0);
}

void add_noise(const NoiseModel& noise, cv::RNG* random, Image3* image) {
  for (Vec3& radiance : *image) {
    for (int c = 0; c < 3; ++c) {
      radiance[c] += float(random->gaussian(std::sqrt(double(noise.variance(radiance[c])))));
    }
  }
}

// Failure: the parallel photograph, set to brighter light, has several times the crossed one's
// noise; deviations that count the crossed one's twice are too small by a third.
TEST(Intensity, DeviatesByTheNoiseOfEachOfTheTwoPhotographs) {
  Skin skin = plain_skin();
  Burst& burst = skin.burst;
  burst.led_parallel_noise = burst.front_parallel_noise = {1e-7, 1.2e-4};
  cv::RNG random(1);
  for (AnalyserPair* pair : {&burst.full, &burst.front}) {
    add_noise(burst.led_parallel_noise, &random, &pair->parallel);
    add_noise(burst.led_noise, &random, &pair->cross);
  }
  const IntensityMap map = estimate_intensity(burst, skin.responses, skin.fits);
  int within_one = 0;
  for (int y = 0; y < map.c.rows; ++y) {
    for (int x = 0; x < map.c.cols; ++x) {
      within_one += std::abs(map.c(y, x) - kTrueC) < map.stddev(y, x);
    }
  }
  EXPECT_NEAR(within_one / double(map.c.total()), 0.68, 0.04);
}

// Failure: a deviation of nothing, which no figure has.
TEST(Intensity, WithoutLightOfItsOwnIsAsUnsureAsNeighboursAreUnlike) {
  Skin skin = plain_skin();
  skin.burst.clipped_led(20, 20) = skin.burst.clipped_projector(20, 20) = 255;
  const IntensityMap map = estimate_intensity(skin.burst, skin.responses, skin.fits);
  EXPECT_NEAR(map.stddev(20, 20) / map.c(20, 20), 0.25f, 1e-3f);
}

// Failure: there S is strongest, and its noise least, but a normal that is off a little makes much
// of it.
TEST(Intensity, IsLessSureWhereItIsSeenAtGrazingAngles) {
  Skin skin = plain_skin();
  skin.responses.front_lobe(20, 20) = 0;
  skin.responses.front_lobe(20, 21) = 0;
  skin.responses.led_slope(20, 20) = 2.5f;
  const IntensityMap map = estimate_intensity(skin.burst, skin.responses, skin.fits);
  EXPECT_LT(map.confidence(20, 20), map.confidence(20, 21) - 0.03f);
}

// Failure: a negative reflectance, or one whose confidence is the quotient of nothing.
TEST(Intensity, OfNegativeLightIsNothing) {
  Skin skin = plain_skin();
  for (AnalyserPair* pair : {&skin.burst.full, &skin.burst.front}) {
    pair->parallel = pair->cross * 0.9;
  }
  const IntensityMap map = estimate_intensity(skin.burst, skin.responses, skin.fits);
  for (const float c : map.c) EXPECT_EQ(c, 0);
  for (const float confidence : map.confidence) EXPECT_TRUE(confidence >= 0 && confidence <= 1);
}

}  // namespace
}  // namespace lamella::fit
