// What is written here OpenEXR itself reads, bit for bit.
#include "io/exr_pack.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <gtest/gtest.h>

#include <fstream>

#include "base/error.h"
#include "base/vec.h"
#include "io/exr.h"
#include "io/fake_session.h"
#include "io/full_disk.h"
#include "io/whole_file.h"

namespace lamella {
namespace {

// Noise does not get smaller and is stored as it is; a ramp and what is all alike do.
enum class Picture { kNoise, kRamp, kUnknown };

Image3 picture_of(Picture picture, int rows, int cols) {
  Image3 out(rows, cols, Vec3::all(kNaN));
  cv::RNG random(5);
  for (int i = 0; picture != Picture::kUnknown && i < rows * cols; ++i) {
    for (int c = 0; c < 3; ++c) {
      out(i / cols, i % cols)[c] =
          picture == Picture::kNoise ? random.uniform(-1.f, 1.f) : 0.01f * float(i + c);
    }
  }
  return out;
}

std::vector<float> read_channel(const fs::path& path, const std::string& name) {
  Imf::InputFile file(path.c_str());
  const Imath::Box2i box = file.header().dataWindow();
  const int cols = box.max.x + 1, rows = box.max.y + 1;
  std::vector<float> values(size_t(rows * cols));
  Imf::FrameBuffer buffer;
  buffer.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), sizeof(float),
                                 sizeof(float) * size_t(cols)));
  file.setFrameBuffer(buffer);
  file.readPixels(0, rows - 1);
  return values;
}

float as_stored(float value, PixelType type) {
  return type == PixelType::kFloat ? value : float(cv::float16_t(value));
}

void expect_same_bits(float a, float b) {
  if (std::isnan(b)) {
    ASSERT_TRUE(std::isnan(a));
  } else {
    ASSERT_EQ(a, b);
  }
}

TEST(ExrPack, IsReadByOpenExrBitForBit) {
  const testing::ScratchFolder scratch;
  const fs::path path = scratch.path() / "a.exr";
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(23, 37), cv::Size(41, 16)}) {
    for (const Picture picture : {Picture::kNoise, Picture::kRamp, Picture::kUnknown}) {
      for (const PixelType type : {PixelType::kHalf, PixelType::kFloat, PixelType::kHalfInRuns}) {
        const Image3 image = picture_of(picture, size.height, size.width);
        write_exr_rgb(path, image, type);
        for (int c = 0; c < 3; ++c) {
          const std::vector<float> read = read_channel(path, std::string(1, "RGB"[c]));
          ASSERT_EQ(read.size(), image.total());
          for (size_t i = 0; i < read.size(); ++i) {
            const Vec3& written = image(int(i) / size.width, int(i) % size.width);
            expect_same_bits(read[i], as_stored(written[c], type));
          }
        }
      }
    }
  }
}

TEST(ExrPack, PutsAPartWhereItBelongsAndOneValueAround) {
  const testing::ScratchFolder scratch;
  const fs::path path = scratch.path() / "a.exr";
  const cv::Size whole(50, 90);
  for (const cv::Rect& area : {cv::Rect(7, 35, 20, 11), cv::Rect(0, 0, 50, 16),
                               cv::Rect(30, 80, 20, 10), cv::Rect(0, 0, 50, 90)}) {
    for (const auto& [value, type] : {std::pair(kNaN, PixelType::kFloat),
                                      {0.f, PixelType::kFloat},
                                      {kNaN, PixelType::kHalfInRuns}}) {
      const Image3 part = picture_of(Picture::kNoise, area.height, area.width);
      write_exr_rgb(path, part, type, ExrSurroundings{{whole, area}, value});
      const std::vector<float> red = read_channel(path, "R");
      ASSERT_EQ(red.size(), size_t(whole.area()));
      for (int i = 0; i < whole.area(); ++i) {
        const cv::Point at(i % whole.width, i / whole.width);
        const bool is_inside = area.contains(at);
        expect_same_bits(red[size_t(i)],
                         as_stored(is_inside ? part(at - area.tl())[0] : value, type));
      }
    }
  }
}

TEST(ExrPack, GivesTheSameBytesForTheSamePixels) {
  const testing::ScratchFolder scratch;
  const Image3 image = picture_of(Picture::kNoise, 200, 90);
  const auto bytes = [&](const char* name) {
    write_exr_rgb(scratch.path() / name, image, PixelType::kHalf);
    std::ifstream in(scratch.path() / name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  EXPECT_EQ(bytes("a.exr"), bytes("b.exr"));
}

// Failure: OpenEXR itself goes on for ever where the disk takes no more.
TEST(ExrPack, SaysWhatTheDiskDoesNotTakeAndLeavesNothing) {
  const testing::ScratchFolder scratch;
  const fs::path path = scratch.path() / "a.exr";
  std::string said;
  try {
    const testing::FullDisk full(4096);
    write_exr_rgb(path, picture_of(Picture::kNoise, 64, 64));
  } catch (const Error& e) {
    said = e.what();
  }
  EXPECT_NE(said.find(path.string() + ": cannot be written (File too large)"), std::string::npos)
      << said;
  EXPECT_TRUE(fs::is_empty(scratch.path()));
}

}  // namespace
}  // namespace lamella
