#include <gtest/gtest.h>

#include <vector>

extern "C" {
#include <linux/videodev2.h>

#include "raw_pixels.h"
}

namespace {

std::vector<uint8_t> packed(const char* format, const std::vector<uint8_t>& rows, size_t width,
                            size_t height, size_t stride) {
  const size_t size[2] = {width, height};
  std::vector<uint8_t> stored(raw_stored_bytes(width, height), 0xee);
  EXPECT_EQ(raw_pack(raw_format_find(format), rows.data(), stride, size, stored.data()),
            stored.size());
  return stored;
}

// Sample number i of stored bytes, as proto/PROTOCOL.md says.
unsigned sample(const std::vector<uint8_t>& stored, size_t i) {
  const uint8_t* p = &stored[i / 2 * 3];
  return i % 2 ? p[1] >> 4 | p[2] << 4 : p[0] | (p[1] & 15) << 8;
}

}  // namespace

TEST(RawPixels, EightBitsBecomeTheUpperEightOfTwelve) {
  const auto stored = packed("GREY", {0x00, 0xff, 0x12, 0x80}, 4, 1, 4);
  EXPECT_EQ(stored, (std::vector<uint8_t>{0x00, 0x00, 0xff, 0x20, 0x01, 0x80}));
}

TEST(RawPixels, TenBitsInWordsAreShiftedUpByTwo) {
  const auto stored = packed("Y10", {0xff, 0x03, 0x01, 0x00}, 2, 1, 4);
  EXPECT_EQ(sample(stored, 0), 0xffcu);
  EXPECT_EQ(sample(stored, 1), 0x004u);
}

TEST(RawPixels, TwelveBitsStayWhatTheyAreWhateverStandsAboveThem) {
  const auto stored = packed("SRGGB12", {0xbc, 0xfa, 0xef, 0x0d}, 2, 1, 4);
  EXPECT_EQ(sample(stored, 0), 0xabcu);
  EXPECT_EQ(sample(stored, 1), 0xdefu);
}

TEST(RawPixels, OfSixteenBitsTheUpperTwelveAreKept) {
  const auto stored = packed("Y16", {0xff, 0xff, 0x0f, 0x80}, 2, 1, 4);
  EXPECT_EQ(sample(stored, 0), 0xfffu);
  EXPECT_EQ(sample(stored, 1), 0x800u);
}

// MIPI CSI-2: the first sample's low bits are the lowest of the last byte.
TEST(RawPixels, PackedTenBitsHaveTheirLowBitsInTheFifthByte) {
  const auto stored = packed("Y10P", {0xff, 0x80, 0x01, 0x00, 0b11'10'01'00}, 4, 1, 5);
  const unsigned expected[] = {0xff << 2 | 0, 0x80 << 2 | 1, 0x01 << 2 | 2, 0x00 << 2 | 3};
  for (size_t i = 0; i < 4; i++) EXPECT_EQ(sample(stored, i), expected[i] << 2) << i;
}

TEST(RawPixels, PackedTwelveBitsHaveTheirLowBitsInTheThirdByte) {
  const auto stored = packed("SBGGR12P", {0xab, 0xde, 0xfc}, 2, 1, 3);
  EXPECT_EQ(sample(stored, 0), 0xabcu);
  EXPECT_EQ(sample(stored, 1), 0xdefu);
}

TEST(RawPixels, RowsOfOddWidthRunOnAndTheirPaddingIsNotRead) {
  const auto stored = packed("GREY", {1, 2, 3, 99, 4, 5, 6, 99, 7, 8, 9}, 3, 3, 4);
  ASSERT_EQ(stored.size(), 15u);
  for (size_t i = 0; i < 9; i++) EXPECT_EQ(sample(stored, i), (i + 1) << 4) << i;
  EXPECT_EQ(stored[13] >> 4, 0);
  EXPECT_EQ(stored[14], 0);
}

TEST(RawPixels, EveryRoundTripOfARampIsTheRamp) {
  std::vector<uint8_t> rows;
  for (int dn = 0; dn < 4096; dn++) {
    rows.push_back(uint8_t(dn));
    rows.push_back(uint8_t(dn >> 8));
  }
  const auto stored = packed("Y12", rows, 64, 64, 128);
  for (size_t i = 0; i < 4096; i++) ASSERT_EQ(sample(stored, i), i);
}

TEST(RawPixels, FormatsAreFoundByTheKernelsNamesAndCodes) {
  const struct {
    const char* name;
    uint32_t fourcc;
    const char* stored;
  } cases[] = {{"GREY", V4L2_PIX_FMT_GREY, "GREY12P"},
               {"Y10", V4L2_PIX_FMT_Y10, "GREY12P"},
               {"Y10P", V4L2_PIX_FMT_Y10P, "GREY12P"},
               {"Y12", V4L2_PIX_FMT_Y12, "GREY12P"},
               {"Y16", V4L2_PIX_FMT_Y16, "GREY12P"},
               {"SRGGB8", V4L2_PIX_FMT_SRGGB8, "RGGB12P"},
               {"SGRBG8", V4L2_PIX_FMT_SGRBG8, "GRBG12P"},
               {"SGBRG8", V4L2_PIX_FMT_SGBRG8, "GBRG12P"},
               {"SBGGR8", V4L2_PIX_FMT_SBGGR8, "BGGR12P"},
               {"SRGGB10", V4L2_PIX_FMT_SRGGB10, "RGGB12P"},
               {"SGRBG10", V4L2_PIX_FMT_SGRBG10, "GRBG12P"},
               {"SGBRG10", V4L2_PIX_FMT_SGBRG10, "GBRG12P"},
               {"SBGGR10", V4L2_PIX_FMT_SBGGR10, "BGGR12P"},
               {"SRGGB10P", V4L2_PIX_FMT_SRGGB10P, "RGGB12P"},
               {"SGRBG10P", V4L2_PIX_FMT_SGRBG10P, "GRBG12P"},
               {"SGBRG10P", V4L2_PIX_FMT_SGBRG10P, "GBRG12P"},
               {"SBGGR10P", V4L2_PIX_FMT_SBGGR10P, "BGGR12P"},
               {"SRGGB12", V4L2_PIX_FMT_SRGGB12, "RGGB12P"},
               {"SGRBG12", V4L2_PIX_FMT_SGRBG12, "GRBG12P"},
               {"SGBRG12", V4L2_PIX_FMT_SGBRG12, "GBRG12P"},
               {"SBGGR12", V4L2_PIX_FMT_SBGGR12, "BGGR12P"},
               {"SRGGB12P", V4L2_PIX_FMT_SRGGB12P, "RGGB12P"},
               {"SGRBG12P", V4L2_PIX_FMT_SGRBG12P, "GRBG12P"},
               {"SGBRG12P", V4L2_PIX_FMT_SGBRG12P, "GBRG12P"},
               {"SBGGR12P", V4L2_PIX_FMT_SBGGR12P, "BGGR12P"},
               {"SRGGB16", V4L2_PIX_FMT_SRGGB16, "RGGB12P"},
               {"SGRBG16", V4L2_PIX_FMT_SGRBG16, "GRBG12P"},
               {"SGBRG16", V4L2_PIX_FMT_SGBRG16, "GBRG12P"},
               {"SBGGR16", V4L2_PIX_FMT_SBGGR16, "BGGR12P"}};
  for (const auto& c : cases) {
    const struct raw_format* format = raw_format_find(c.name);
    ASSERT_NE(format, nullptr) << c.name;
    EXPECT_EQ(format->fourcc, c.fourcc) << c.name;
    EXPECT_STREQ(format->stored, c.stored) << c.name;
    EXPECT_EQ(raw_format_of_fourcc(c.fourcc), format) << c.name;
  }
  EXPECT_EQ(raw_format_find("YUYV"), nullptr);
  EXPECT_EQ(raw_format_of_fourcc(V4L2_PIX_FMT_YUYV), nullptr);
}
