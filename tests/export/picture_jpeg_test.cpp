// JPEG textures, as OpenCV's reader sees them.
#include "export/picture_jpeg.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "base/error.h"

namespace lamella::exporting {
namespace {

// Smooth, as skin is; each channel another way, so that none can stand for another.
cv::Mat3b smooth_picture() {
  cv::Mat3b bgr(45, 61);
  for (int y = 0; y < bgr.rows; ++y) {
    for (int x = 0; x < bgr.cols; ++x) bgr(y, x) = {uchar(3 * x), uchar(5 * y), uchar(90 + x + y)};
  }
  return bgr;
}

double mean_error(const cv::Mat3b& picture, int quality) {
  const cv::Mat3b read = cv::imdecode(encode_jpeg(picture, quality), cv::IMREAD_COLOR);
  EXPECT_EQ(read.size(), picture.size());
  return cv::norm(read, picture, cv::NORM_L1) / double(3 * picture.total());
}

TEST(PictureJpeg, IsReadByOpenCvNearlyAsItWasAndNearerWithMoreQuality) {
  EXPECT_LT(mean_error(smooth_picture(), 92), 2.0);
  EXPECT_LT(mean_error(smooth_picture(), 92), 0.5 * mean_error(smooth_picture(), 20));
}

// ITU T.81: SOF0 is baseline; each component has its sampling factors behind its number.
TEST(PictureJpeg, IsBaselineWithHalfOfTheChromaEachWay) {
  const std::vector<uchar> bytes = encode_jpeg(smooth_picture(), 92);
  const std::vector<uchar> start{0xff, 0xc0, 0, 17, 8, 0, 45, 0, 61, 3, 1, 0x22};
  const auto at = std::search(bytes.begin(), bytes.end(), start.begin(), start.end());
  ASSERT_NE(at, bytes.end());
  EXPECT_EQ(at[14], 0x11);
  EXPECT_EQ(at[17], 0x11);
}

TEST(PictureJpeg, HasRoomForNoiseAtTheHighestQuality) {
  cv::Mat3b noise(64, 64);
  cv::RNG(5).fill(noise, cv::RNG::UNIFORM, 0, 256);
  for (uchar& v : cv::Mat1b(64, 192, noise.ptr())) v = v < 128 ? 0 : 255;
  EXPECT_EQ(cv::imdecode(encode_jpeg(noise, 100), cv::IMREAD_COLOR).size(), noise.size());
}

TEST(PictureJpeg, ThatTheFormatCannotHoldIsRefusedInOneLineWithoutLibjpegsOwn) {
  for (const cv::Size size : {cv::Size(65501, 1), cv::Size(0, 0)}) {
    ::testing::internal::CaptureStderr();
    EXPECT_THROW(encode_jpeg(cv::Mat3b(size), 92), Error);
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  }
}

}  // namespace
}  // namespace lamella::exporting
