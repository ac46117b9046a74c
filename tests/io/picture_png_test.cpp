// PNG pictures: what OpenCV's own reader and writer make of the same bytes, and bytes that are
// none.
#include "io/picture_png.h"

#include <gtest/gtest.h>
#include <png.h>
#include <zlib.h>

#include <opencv2/imgcodecs.hpp>

#include "io/expect_error.h"
#include "io/exr.h"

namespace lamella {
namespace {

using testing::complaint;
using testing::names;

// Ramps with some noise: every filter and every row differs.
cv::Mat ramps(int type, cv::Size size = {37, 23}) {
  cv::Mat picture(size, type);
  cv::RNG random(3);
  random.fill(picture, cv::RNG::UNIFORM, 0, 40);
  for (int y = 0; y < size.height; ++y) picture.row(y) += cv::Scalar::all(5 * y);
  return picture;
}

bool are_equal(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0;
}

cv::Mat as_opencv_reads(const std::string& bytes) {
  return cv::imdecode(std::vector<uchar>(bytes.begin(), bytes.end()), cv::IMREAD_UNCHANGED);
}

std::string as_opencv_writes(const cv::Mat& picture) {
  std::vector<uchar> bytes;
  cv::imencode(".png", picture, bytes);
  return {bytes.begin(), bytes.end()};
}

// Of a kind that OpenCV does not write.
struct Kind {
  int colour, bits, interlace;
};

std::string file_of(const Kind& kind, double gamma = 0) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  const auto append = [](png_structp p, png_bytep more, size_t count) {
    static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<char*>(more), count);
  };
  png_set_write_fn(png, &bytes, append, nullptr);
  png_set_IHDR(png, info, 13, 11, kind.bits, kind.colour, kind.interlace, 0, 0);
  std::array<png_color, 4> palette{{{1, 2, 3}, {40, 50, 60}, {0, 0, 255}, {255, 255, 0}}};
  if (kind.colour == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(png, info, palette.data(), 4);
  if (gamma > 0) png_set_gAMA(png, info, gamma);
  png_write_info(png, info);
  cv::Mat1b rows(11, 13 * 8);
  cv::RNG(7).fill(rows, cv::RNG::UNIFORM, 0, 256);
  for (int pass = png_set_interlace_handling(png); pass > 0; --pass) {
    for (int y = 0; y < rows.rows; ++y) png_write_row(png, rows.ptr(y));
  }
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

TEST(PicturePng, ReadsWhatOpenCvWrote) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3}) {
    const cv::Mat picture = ramps(type);
    EXPECT_TRUE(are_equal(decode_png(as_opencv_writes(picture), "a.png"), picture)) << type;
  }
}

TEST(PicturePng, IsReadByOpenCvAndByItselfAsItWasWritten) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4}) {
    for (const PngEffort effort : {PngEffort::kQuick, PngEffort::kSmall}) {
      const cv::Mat picture = ramps(type);
      const std::string bytes = encode_png(picture, effort);
      EXPECT_TRUE(are_equal(as_opencv_reads(bytes), picture)) << type;
      if (type == CV_8UC4) continue;
      EXPECT_TRUE(are_equal(decode_png(bytes, "a.png"), picture)) << type;
    }
  }
  const cv::Mat whole = ramps(CV_8UC1), part = whole(cv::Rect(3, 2, 20, 11));
  EXPECT_TRUE(are_equal(decode_png(encode_png(part), "a.png"), part));
}

TEST(PicturePng, ReadsFewBitsPalettesAndInterlacedRowsAsOpenCvDoes) {
  for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7}) {
    for (const Kind& kind :
         {Kind{PNG_COLOR_TYPE_GRAY, 1, interlace}, Kind{PNG_COLOR_TYPE_GRAY, 2, interlace},
          Kind{PNG_COLOR_TYPE_GRAY, 4, interlace}, Kind{PNG_COLOR_TYPE_GRAY, 16, interlace},
          Kind{PNG_COLOR_TYPE_PALETTE, 2, interlace}, Kind{PNG_COLOR_TYPE_RGB, 8, interlace}}) {
      const std::string bytes = file_of(kind);
      EXPECT_TRUE(are_equal(decode_png(bytes, "a.png"), as_opencv_reads(bytes)))
          << kind.colour << " " << kind.bits << " " << interlace;
      const PngHeader header = png_header(bytes, "a.png");
      EXPECT_EQ(header.size, cv::Size(13, 11));
      EXPECT_EQ(header.bits, kind.bits);
      EXPECT_EQ(header.is_grey, kind.colour == PNG_COLOR_TYPE_GRAY);
    }
  }
}

TEST(PicturePng, LeavesAlphaOut) {
  const cv::Mat grey = decode_png(file_of({PNG_COLOR_TYPE_GRAY_ALPHA, 8, 0}), "a.png");
  EXPECT_EQ(grey.type(), CV_8UC1);
  const std::string bytes = file_of({PNG_COLOR_TYPE_RGB_ALPHA, 8, 0});
  const cv::Mat colour = decode_png(bytes, "a.png"), with_alpha = as_opencv_reads(bytes);
  ASSERT_EQ(colour.type(), CV_8UC3);
  for (int i = 0; i < 13 * 11; ++i) {
    const cv::Vec4b& v = with_alpha.at<cv::Vec4b>(i / 13, i % 13);
    EXPECT_EQ(colour.at<cv::Vec3b>(i / 13, i % 13), cv::Vec3b(v[0], v[1], v[2]));
  }
}

TEST(PicturePng, HasTheSameValuesWhateverTheFileSaysOfGamma) {
  const Kind grey{PNG_COLOR_TYPE_GRAY, 8, 0};
  EXPECT_TRUE(
      are_equal(decode_png(file_of(grey, 1.0), "a.png"), decode_png(file_of(grey), "a.png")));
}

// What `bytes` are refused with, in one line and nothing beside it.
std::string refusal(const std::string& bytes) {
  ::testing::internal::CaptureStderr();
  const std::string line = complaint([&] { decode_png(bytes, "a.png"); });
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  return line;
}

TEST(PicturePng, ThatIsDamagedIsRefusedInOneLineWithoutLibpngsOwn) {
  const std::string good = encode_png(ramps(CV_8UC1));
  ASSERT_EQ(refusal(good), "");
  EXPECT_TRUE(names(refusal("GIF89a"), {"a.png", "not a PNG image"}));
  EXPECT_TRUE(names(refusal(good.substr(0, good.size() - 1)), {"a.png", "not a whole PNG"}));
  const size_t last_of_rows = good.size() - 13;  // before the chunk that ends it
  for (const size_t at : {size_t(24), size_t(30), size_t(37), size_t(60), last_of_rows}) {
    std::string bad = good;
    bad[at] ^= 0x10;
    EXPECT_TRUE(names(refusal(bad), {"a.png: damaged PNG image"})) << at;
  }
  std::string without_rows = good;
  without_rows.erase(33, good.size() - 33 - 12);
  EXPECT_TRUE(names(refusal(without_rows), {"a.png: damaged PNG image"}));
  std::string beyond_its_end = good;
  beyond_its_end.insert(good.size() - 12, std::string("\0\0\1\0tEXt", 8));
  EXPECT_TRUE(names(refusal(beyond_its_end), {"a.png: damaged PNG image"}));
}

// libpng warns of these and reads the picture.
TEST(PicturePng, IsReadInSilenceWhereOnlyAChunkBesideItIsDamaged) {
  std::string bytes = file_of({PNG_COLOR_TYPE_GRAY, 8, 0}, 0.5);
  const size_t at = bytes.find("gAMA");
  ASSERT_NE(at, std::string::npos);
  bytes[at + 7] ^= 1;
  EXPECT_EQ(refusal(bytes), "");
}

TEST(PicturePng, OfMorePixelsThanAreReadIsRefusedBeforeThereIsMemoryForThem) {
  std::string bytes = encode_png(ramps(CV_8UC1));
  bytes.replace(16, 8, std::string("\x00\x00\x80\x01\x00\x00\x00\x01", 8));
  EXPECT_TRUE(names(refusal(bytes), {"a.png: 32769x1 pixels", "32768 a side"}));
  bytes.replace(16, 8, std::string("\x00\x00\x40\x00\x00\x00\x20\x01", 8));
  EXPECT_TRUE(names(refusal(bytes), {"a.png: 16384x8193 pixels", "134 million"}));
  bytes.replace(16, 8, std::string("\x00\x00\x00\x00\x00\x00\x00\x01", 8));
  EXPECT_TRUE(names(refusal(bytes), {"a.png: damaged"}));
}

// What it says of its size could else be some text's bytes.
TEST(PicturePng, WhoseHeaderIsNotItsFirstChunkIsDamaged) {
  const std::string name_and_text("tEXt\0\0\0\1\0\0\0\1", 12);
  const uLong crc = crc32(0, reinterpret_cast<const Bytef*>(name_and_text.data()), 12);
  std::string chunk = std::string("\0\0\0\x08", 4) + name_and_text;
  for (int shift = 24; shift >= 0; shift -= 8) chunk += char(crc >> shift);
  std::string bytes = encode_png(ramps(CV_8UC1));
  bytes.insert(8, chunk);
  EXPECT_TRUE(names(complaint([&] { png_header(bytes, "a.png"); }), {"a.png: damaged PNG image"}));
}

TEST(PicturePng, OfLabelsIsSmallerThanOpenCvMakesItAndSmallerStillWithEffort) {
  Labels labels(200, 150, uchar(0));
  for (int y = 0; y < labels.rows; ++y) {
    for (int x = 0; x < labels.cols; ++x) labels(y, x) = uchar(std::hypot(x - 75, y - 90) / 20);
  }
  const size_t quick = encode_png(labels).size();
  EXPECT_LT(quick, as_opencv_writes(labels).size());
  EXPECT_LT(encode_png(labels, PngEffort::kSmall).size(), quick);
}

TEST(PicturePng, WithoutAPixelIsNotWritten) {
  EXPECT_TRUE(names(complaint([] { encode_png(cv::Mat1b(0, 0)); }), {"0x0 pixels", "PNG"}));
}

}  // namespace
}  // namespace lamella
