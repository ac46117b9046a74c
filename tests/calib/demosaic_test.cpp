#include "calib/demosaic.h"

#include <gtest/gtest.h>

#include "calib/develop.h"

namespace lamella {
namespace {

constexpr RawPixels kOrders[] = {RawPixels::kRggb, RawPixels::kGrbg, RawPixels::kGbrg,
                                 RawPixels::kBggr};
constexpr float kNever = 1e30f;

// Which colour a sample of the mosaic has: 0 red, 1 green, 2 blue. Written as the formats' names
// say it, the first two rows one after the other.
int colour_at(RawPixels order, int y, int x) {
  const char* names[] = {"RGGB", "GRBG", "GBRG", "BGGR"};
  const char c = names[int(order) - int(RawPixels::kRggb)][2 * (y % 2) + x % 2];
  return c == 'R' ? 0 : c == 'G' ? 1 : 2;
}

template <class Colour>
Image1 mosaic_of(RawPixels order, cv::Size size, const Colour& colour) {
  Image1 mosaic(size);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      mosaic(y, x) = colour(y, x)[colour_at(order, y, x)];
    }
  }
  return mosaic;
}

TEST(Demosaic, AFlatColourComesBackExactlyInEveryOrderAndSize) {
  const Vec3 flat(0.75f, 0.5f, -0.125f);
  for (RawPixels order : kOrders) {
    for (const cv::Size size : {cv::Size(2, 2), cv::Size(3, 5), cv::Size(8, 2), cv::Size(31, 17)}) {
      const Image3 image =
          demosaic(mosaic_of(order, size, [&](int, int) { return flat; }), order, kNever);
      EXPECT_EQ(cv::norm(image, Image3(size, flat), cv::NORM_INF), 0) << int(order) << size;
    }
  }
}

TEST(Demosaic, ARampComesBackExactlyInsideTheBorder) {
  const auto ramp = [](int y, int x) {
    return Vec3(float(4 * x + y), float(2 * x - 4 * y), float(8 * y));
  };
  const cv::Size size(12, 10);
  for (RawPixels order : kOrders) {
    const Image3 image = demosaic(mosaic_of(order, size, ramp), order, kNever);
    for (int y = 1; y < size.height - 1; ++y) {
      for (int x = 1; x < size.width - 1; ++x) {
        EXPECT_EQ(image(y, x), ramp(y, x)) << int(order) << " " << y << " " << x;
      }
    }
  }
}

TEST(Demosaic, IsLinearInTheSamples) {
  Image1 a(9, 7), b(9, 7);
  cv::randu(a, -1.f, 1.f);
  cv::randu(b, -1.f, 1.f);
  const Image1 sum = 2 * a + b;
  const Image3 expected =
      2 * demosaic(a, RawPixels::kGbrg, kNever) + demosaic(b, RawPixels::kGbrg, kNever);
  EXPECT_LT(cv::norm(demosaic(sum, RawPixels::kGbrg, kNever), expected, cv::NORM_INF), 1e-6);
}

TEST(Demosaic, WhatAClippedSampleWentIntoIsClippedAndNothingElse) {
  Image1 mosaic(7, 7, 0.25f);
  mosaic(2, 2) = 1.f;  // red in RGGB
  const Image3 image = demosaic(mosaic, RawPixels::kRggb, 1.f);
  int clipped = 0;
  for (const Vec3& pixel : image) {
    for (int c = 0; c < 3; ++c) {
      clipped += pixel[c] >= 1.f;
      EXPECT_TRUE(pixel[c] == 0.25f || pixel[c] == 1.f);
    }
  }
  EXPECT_EQ(clipped, 9) << "the red of itself and of its eight neighbours";
}

TEST(Demosaic, PermutedOrdersOfOneSceneAgree) {
  const auto scene = [](int y, int x) { return Vec3(float(x), float(y), float(x + y)); };
  const Image3 first =
      demosaic(mosaic_of(RawPixels::kRggb, {10, 10}, scene), RawPixels::kRggb, kNever);
  for (RawPixels order : kOrders) {
    const Image3 image = demosaic(mosaic_of(order, {10, 10}, scene), order, kNever);
    EXPECT_EQ(image(4, 5), first(4, 5)) << int(order);
  }
}

std::vector<uint8_t> packed(const std::vector<uint16_t>& samples) {
  std::vector<uint8_t> bytes;
  for (size_t i = 0; i < samples.size(); i += 2) {
    const uint16_t a = samples[i], b = i + 1 < samples.size() ? samples[i + 1] : 0;
    bytes.insert(bytes.end(), {uint8_t(a), uint8_t(a >> 8 | (b & 15) << 4), uint8_t(b >> 4)});
  }
  return bytes;
}

TEST(DevelopPlane, GreyBecomesThreeEqualChannels) {
  const RawFormat format{64, 1.0 / 4000, 1.0, RawPixels::kGrey};
  const Image3 image = develop(packed({64, 2064, 64, 64, 64, 4064, 64, 64, 64}), {3, 3}, format);
  ASSERT_EQ(image.size(), cv::Size(3, 3));
  EXPECT_EQ(image(0, 0), Vec3(0, 0, 0));
  EXPECT_EQ(image(0, 1), Vec3::all(0.5f));
  EXPECT_GE(image(1, 2)[0], 1.f);
  EXPECT_EQ(image(1, 2)[0], image(1, 2)[2]);
}

TEST(DevelopPlane, AMosaicKeepsItsColours) {
  const RawFormat format{0, 1.0 / 1000, 4.0, RawPixels::kBggr};
  const Image3 image = develop(packed({100, 200, 200, 300}), {2, 2}, format);
  for (const Vec3& pixel : image) EXPECT_LT(cv::norm(pixel - Vec3(0.3f, 0.2f, 0.1f)), 1e-6);
}

// An eight-bit sensor ends at 255 << 4.
TEST(DevelopPlane, FullScaleIsClippedThoughItsGainWasRounded) {
  for (double full_scale : {4080., 4092., 4095., 3999.}) {
    for (double black : {0., 63., 64., 241.}) {
      const RawFormat format{black, 1 / (full_scale - black), 1.0, RawPixels::kGrey};
      EXPECT_GE(develop(packed({uint16_t(full_scale)}), {1, 1}, format)(0, 0)[0], 1.f);
      EXPECT_LT(develop(packed({uint16_t(full_scale - 1)}), {1, 1}, format)(0, 0)[0], 1.f);
    }
  }
}

TEST(DevelopPlane, GivesNothingForBytesOfAnotherSizeOrAMosaicWithoutAllColours) {
  EXPECT_TRUE(develop(packed({1, 2, 3}), {2, 3}, {0, 1, 1, RawPixels::kGrey}).empty());
  EXPECT_TRUE(develop(packed({1, 2, 3}), {3, 1}, {0, 1, 1, RawPixels::kRggb}).empty());
  EXPECT_EQ(raw12_bytes(RawPixels::kRggb, 3, 1), 0u);
  EXPECT_EQ(raw12_bytes(RawPixels::kGrey, 3, 1), 6u);
}

}  // namespace
}  // namespace lamella
