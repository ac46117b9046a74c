#include "io/raw12.h"

#include <gtest/gtest.h>

namespace lamella {
namespace {

RawImage ramp(int rows, int cols) {
  RawImage image(rows, cols);
  int next = 0;
  for (auto& pixel : image) {
    for (int c = 0; c < 3; ++c) pixel[c] = uint16_t((next++ * 37) & 0xfff);
  }
  return image;
}

TEST(Raw12, PutsTwoSamplesIntoThreeBytesLowBitsFirst) {
  RawImage image(1, 1);
  image(0, 0) = {0xabc, 0xdef, 0x123};
  const std::vector<uint8_t> expected{0xbc, 0xfa, 0xde, 0x23, 0x01, 0x00};
  EXPECT_EQ(pack_rgb12p(image), expected);
}

TEST(Raw12, ComesBackAsItWasPackedForOddAndEvenNumbersOfSamples) {
  for (const cv::Size size :
       {cv::Size(1, 1), cv::Size(3, 5), cv::Size(24, 32), cv::Size(301, 211)}) {
    const RawImage image = ramp(size.height, size.width);
    const std::vector<uint8_t> bytes = pack_rgb12p(image);
    EXPECT_EQ(bytes.size(), rgb12p_bytes(size_t(size.width), size_t(size.height)));
    const RawImage back = unpack_rgb12p(bytes.data(), bytes.size(), size);
    EXPECT_EQ(cv::norm(image, back, cv::NORM_INF), 0) << size;
  }
}

TEST(Raw12, MapsEverySampleThroughTheTable) {
  const RawImage image = ramp(7, 9);
  Raw12Table table;
  for (int dn = 0; dn < kRaw12Levels; ++dn) table[size_t(dn)] = 0.5f * float(dn) - 3;
  const std::vector<uint8_t> bytes = pack_rgb12p(image);
  const Image3 mapped = map_rgb12p(bytes.data(), bytes.size(), image.size(), table);
  EXPECT_FLOAT_EQ(mapped(6, 8)[2], 0.5f * float(image(6, 8)[2]) - 3);
  EXPECT_FLOAT_EQ(mapped(0, 0)[0], 0.5f * float(image(0, 0)[0]) - 3);
}

TEST(Raw12, RefusesAByteCountThatDisagreesWithTheSize) {
  const std::vector<uint8_t> bytes(rgb12p_bytes(4, 4));
  EXPECT_TRUE(unpack_rgb12p(bytes.data(), bytes.size() - 1, {4, 4}).empty());
  EXPECT_TRUE(unpack_rgb12p(bytes.data(), bytes.size(), {4, 5}).empty());
  EXPECT_TRUE(unpack_rgb12p(bytes.data(), bytes.size(), {-4, -4}).empty());
}

}  // namespace
}  // namespace lamella
