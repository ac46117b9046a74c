// What libdeflate makes of a file is what OpenEXR itself makes of it.
#include "io/exr_unpack.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <gtest/gtest.h>

#include <fstream>

#include "base/error.h"
#include "base/vec.h"
#include "io/exr.h"
#include "io/fake_session.h"
#include "io/whole_file.h"

namespace lamella {
namespace {

// Noise does not get smaller and is stored as it is; a ramp does.
Image1 image(int rows, int cols, bool is_noise) {
  Image1 out(rows, cols);
  cv::RNG random(5);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < cols; ++x) {
      out(y, x) = is_noise ? random.uniform(-1.f, 1.f) : 0.01f * float(x + y);
    }
  }
  return out;
}

struct Kind {
  Imf::Compression compression;
  Imf::LineOrder order;
  int rows, cols;
  bool is_noise;
};

void write(const fs::path& path, const Kind& kind, const Image1& values) {
  Imf::Header header(kind.cols, kind.rows);
  header.compression() = kind.compression;
  header.lineOrder() = kind.order;
  header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
  header.channels().insert("A", Imf::Channel(Imf::FLOAT));
  Imf::FrameBuffer buffer;
  char* const base = reinterpret_cast<char*>(values.data);
  buffer.insert("Y", Imf::Slice(Imf::FLOAT, base, sizeof(float), values.step[0]));
  buffer.insert("A", Imf::Slice(Imf::FLOAT, base, sizeof(float), values.step[0]));
  Imf::OutputFile file(path.c_str(), header, 0);
  file.setFrameBuffer(buffer);
  for (int i = 0; i < kind.rows; ++i) file.writePixels(1);
}

Image3 rgb_image(int rows, int cols) {
  Image3 out(rows, cols);
  cv::RNG random(3);
  for (Vec3& v : out) v = Vec3(random.uniform(0.f, 1.f), random.uniform(0.f, 1.f), 0.25f);
  return out;
}

TEST(ExrUnpack, ReadsWhatOpenExrWroteBitForBit) {
  const testing::ScratchFolder scratch;
  const fs::path path = scratch.path() / "a.exr";
  for (const Kind& kind : {Kind{Imf::ZIP_COMPRESSION, Imf::INCREASING_Y, 37, 23, false},
                           Kind{Imf::ZIP_COMPRESSION, Imf::DECREASING_Y, 32, 8, false},
                           Kind{Imf::ZIPS_COMPRESSION, Imf::INCREASING_Y, 5, 1, false},
                           Kind{Imf::ZIPS_COMPRESSION, Imf::INCREASING_Y, 5, 41, true},
                           Kind{Imf::ZIP_COMPRESSION, Imf::INCREASING_Y, 17, 41, true},
                           Kind{Imf::RLE_COMPRESSION, Imf::INCREASING_Y, 5, 400, false},
                           Kind{Imf::RLE_COMPRESSION, Imf::DECREASING_Y, 5, 41, true}}) {
    const Image1 values = image(kind.rows, kind.cols, kind.is_noise);
    write(path, kind, values);
    Image1 got(values.size(), kNaN);
    Imf::InputFile file(path.c_str(), 0);
    ASSERT_TRUE(read_packed_planes(
        &file, {{"Y", reinterpret_cast<char*>(got.data), sizeof(float), got.step[0]}},
        {cv::Rect({0, 0}, got.size())}));
    EXPECT_EQ(cv::norm(values, got, cv::NORM_INF), 0) << kind.rows << "x" << kind.cols;
  }
}

TEST(ExrUnpack, ReadsAPartAsItIsInTheWhole) {
  const testing::ScratchFolder scratch;
  const fs::path path = scratch.path() / "a.exr";
  const Image3 image = rgb_image(70, 41);
  for (const PixelType type : {PixelType::kHalf, PixelType::kFloat}) {
    write_exr_rgb(path, image, type);
    const Image3 whole = read_exr_rgb(path);
    for (const cv::Rect& area : {cv::Rect(0, 0, 41, 70), cv::Rect(5, 17, 1, 1),
                                 cv::Rect(3, 15, 30, 34), cv::Rect(40, 64, 1, 6)}) {
      const Image3 part = read_finite_rgb(path, area);
      ASSERT_EQ(part.size(), area.size());
      EXPECT_EQ(cv::norm(part, whole(area), cv::NORM_INF), 0) << area;
    }
  }
}

TEST(ExrUnpack, ReadsAPartOfWhatIsCompressedOtherwise) {
  const testing::ScratchFolder scratch;
  const fs::path path = scratch.path() / "a.exr";
  const Image3 image = rgb_image(20, 30);
  Imf::Header header(30, 20);
  header.compression() = Imf::PIZ_COMPRESSION;
  Imf::FrameBuffer buffer;
  for (int c = 0; c < 3; ++c) {
    const std::string name(1, "RGB"[c]);
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    char* first = reinterpret_cast<char*>(image.data) + size_t(c) * sizeof(float);
    buffer.insert(name, Imf::Slice(Imf::FLOAT, first, sizeof(Vec3), image.step[0]));
  }
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(20);
  const cv::Rect area(4, 3, 20, 11);
  EXPECT_EQ(cv::norm(read_finite_rgb(path, area), image(area), cv::NORM_INF), 0);
}

// Failure: a copy that broke off would be fitted where the subject ends above what is missing.
TEST(ExrUnpack, RefusesACutFileEvenWhereThePartIsWhole) {
  const testing::ScratchFolder scratch;
  const fs::path path = scratch.path() / "a.exr";
  write_exr_rgb(path, rgb_image(70, 41));
  fs::resize_file(path, fs::file_size(path) - 100);
  EXPECT_THROW(read_finite_rgb(path, {0, 0, 41, 20}), Error);
}

TEST(ExrUnpack, RefusesWhatIsNoNumberInsideOfAPartAndOutside) {
  const testing::ScratchFolder scratch;
  const fs::path path = scratch.path() / "a.exr";
  const cv::Rect area(5, 20, 10, 10);
  for (const PixelType type : {PixelType::kHalf, PixelType::kFloat}) {
    for (const cv::Point at : {cv::Point(7, 25), cv::Point(40, 25), cv::Point(3, 69)}) {
      Image3 image = rgb_image(70, 41);
      image(at)[1] = at.x == 40 ? std::numeric_limits<float>::infinity() : kNaN;
      write_exr_rgb(path, image, type);
      const std::string place = "(" + std::to_string(at.x) + ", " + std::to_string(at.y) + ")";
      try {
        read_finite_rgb(path, area);
        ADD_FAILURE() << place << " was read";
      } catch (const Error& e) {
        EXPECT_NE(std::string(e.what()).find(place), std::string::npos) << e.what();
      }
    }
  }
}

TEST(ExrUnpack, LeavesOtherCompressionsToOpenExr) {
  const testing::ScratchFolder scratch;
  const fs::path path = scratch.path() / "a.exr";
  const Kind kind{Imf::PIZ_COMPRESSION, Imf::INCREASING_Y, 20, 20, false};
  const Image1 values = image(20, 20, false);
  write(path, kind, values);
  Image1 got(values.size(), kNaN);
  Imf::InputFile file(path.c_str(), 0);
  EXPECT_FALSE(read_packed_planes(
      &file, {{"Y", reinterpret_cast<char*>(got.data), sizeof(float), got.step[0]}},
      {cv::Rect({0, 0}, got.size())}));
  EXPECT_EQ(cv::norm(values, read_exr(path, {"Y"})[0], cv::NORM_INF), 0);
}

TEST(ExrUnpack, SaysWhichLineIsDamaged) {
  const testing::ScratchFolder scratch;
  const fs::path path = scratch.path() / "a.exr";
  write(path, {Imf::ZIP_COMPRESSION, Imf::INCREASING_Y, 37, 23, false}, image(37, 23, false));
  std::fstream bytes(path, std::ios::in | std::ios::out | std::ios::binary);
  bytes.seekp(-20, std::ios::end);
  bytes.write("damaged!", 8);
  bytes.close();
  Image1 got(37, 23);
  Imf::InputFile file(path.c_str(), 0);
  try {
    read_packed_planes(&file,
                       {{"Y", reinterpret_cast<char*>(got.data), sizeof(float), got.step[0]}},
                       {cv::Rect({0, 0}, got.size())});
    FAIL() << "the damage was not seen";
  } catch (const std::exception& e) {
    EXPECT_NE(std::string(e.what()).find("line 32"), std::string::npos) << e.what();
  }
}

// Failure: of run lengths, and of what is stored as it is, another number was read.
TEST(ExrUnpack, SeesABitThatFlippedInAnyPixel) {
  const testing::ScratchFolder scratch;
  const fs::path path = scratch.path() / "a.exr";
  for (const PixelType type : {PixelType::kHalf, PixelType::kFloat, PixelType::kHalfInRuns}) {
    write_exr_rgb(path, rgb_image(30, 41), type);
    const std::string whole = read_text(path);
    for (size_t at = whole.size() - 1; at > whole.size() - 2000; at -= 97) {
      std::string damaged = whole;
      damaged[at] = char(damaged[at] ^ 0x10);
      write_whole_text(path, damaged);
      EXPECT_THROW(read_exr_rgb(path), Error) << at;
      EXPECT_THROW(read_finite_rgb(path, {0, 0, 3, 3}), Error) << at;
    }
  }
}

}  // namespace
}  // namespace lamella
