#include "fit/share_detail.h"

#include <gtest/gtest.h>

namespace lamella::fit {
namespace {

constexpr int kSkinSide_px = 96, kWindow_px = 7;
constexpr float kPlainShare = 0.4f, kShareNoise = 0.03f, kMoleShare = 0.05f;

// A mole every 12 pixels that changes all channels, in two regions, the right one of other shares.
float true_share(int y, int x) {
  const bool mole = y % 12 < 4 && x % 12 < 4;
  return (x < kSkinSide_px / 2 ? kPlainShare : 1.5f * kPlainShare) + (mole ? kMoleShare : 0.f);
}

struct Made {
  Labels regions = Labels(kSkinSide_px, kSkinSide_px, uchar(1));
  ShareMap map{Image3(kSkinSide_px, kSkinSide_px), Image3(kSkinSide_px, kSkinSide_px)};
};

Made made(float noise, uint64_t seed = 1) {
  Made made;
  cv::RNG random(seed);
  for (int y = 0; y < kSkinSide_px; ++y) {
    for (int x = 0; x < kSkinSide_px; ++x) {
      made.regions(y, x) = x < kSkinSide_px / 2 ? 1 : 2;
      for (int c = 0; c < 3; ++c) {
        made.map.share(y, x)[c] = true_share(y, x) + float(random.gaussian(double(noise)));
        made.map.noise_variance(y, x)[c] = noise * noise;
      }
    }
  }
  return made;
}

double rms_error(const ShareMap& map) {
  double sum = 0;
  for (int y = 0; y < kSkinSide_px; ++y) {
    for (int x = 0; x < kSkinSide_px; ++x) {
      for (int c = 0; c < 3; ++c) {
        const double error = double(map.share(y, x)[c] - true_share(y, x));
        sum += error * error / (3.0 * kSkinSide_px * kSkinSide_px);
      }
    }
  }
  return std::sqrt(sum);
}

double mean_variance(const ShareMap& map) {
  const cv::Scalar sums = cv::mean(map.noise_variance);
  return (sums[0] + sums[1] + sums[2]) / 3;
}

// Flattened, the moles alone would be off by half of the noise.
TEST(ShareDetail, TakesMostOfTheNoiseAndLeavesTheMolesAndTheBorder) {
  Made noisy = made(kShareNoise);
  remove_share_noise(noisy.regions, 2, kWindow_px, &noisy.map);
  EXPECT_LT(rms_error(noisy.map), 0.46 * double(kShareNoise));
}

// Failure: what of the skin was taken for noise is not in it.
TEST(ShareDetail, SaysHowFarOffNoiseLeavesIt) {
  Made noisy = made(kShareNoise);
  remove_share_noise(noisy.regions, 2, kWindow_px, &noisy.map);
  EXPECT_NEAR(std::sqrt(mean_variance(noisy.map)) / rms_error(noisy.map), 1, 0.1);
}

TEST(ShareDetail, ChangesNothingWithoutNoise) {
  Made clean = made(0);
  remove_share_noise(clean.regions, 2, kWindow_px, &clean.map);
  EXPECT_LT(rms_error(clean.map), 1e-5);
}

TEST(ShareDetail, OfNothingButNoiseLeavesTheMean) {
  Made even = made(0);
  even.regions.setTo(1);
  cv::RNG random(2);
  for (Vec3& share : even.map.share) {
    for (int c = 0; c < 3; ++c)
      share[c] = kPlainShare + float(random.gaussian(double(kShareNoise)));
  }
  even.map.noise_variance.setTo(cv::Scalar::all(double(kShareNoise * kShareNoise)));
  remove_share_noise(even.regions, 1, kWindow_px, &even.map);
  double sum = 0;
  for (const Vec3& share : even.map.share)
    sum += double(share[1] - kPlainShare) * double(share[1] - kPlainShare);
  EXPECT_LT(std::sqrt(sum / (kSkinSide_px * kSkinSide_px)), 0.25 * double(kShareNoise));
}

TEST(ShareDetail, LeavesPixelsWithoutAShareAndTinyRegionsAlone) {
  Made noisy = made(kShareNoise);
  noisy.regions(cv::Rect(0, 0, 5, 5)).setTo(3);
  noisy.map.share(20, 20) = Vec3(kNaN, kNaN, kNaN);
  const Image3 before = noisy.map.share.clone();
  remove_share_noise(noisy.regions, 4, kWindow_px, &noisy.map);
  EXPECT_FALSE(is_finite(noisy.map.share(20, 20)));
  EXPECT_TRUE(is_finite(noisy.map.share(20, 21)));
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 5; ++x) EXPECT_EQ(noisy.map.share(y, x), before(y, x));
  }
}

}  // namespace
}  // namespace lamella::fit
