// What is written here OpenEXR itself reads, bit for bit.
#include "io/exr_zip_write.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <gtest/gtest.h>

#include <fstream>

#include "base/vec.h"
#include "io/exr.h"
#include "io/fake_session.h"
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
  return type == PixelType::kHalf ? float(cv::float16_t(value)) : value;
}

void expect_same_bits(float a, float b) {
  if (std::isnan(b)) {
    ASSERT_TRUE(std::isnan(a));
  } else {
    ASSERT_EQ(a, b);
  }
}

TEST(ExrZipWrite, IsReadByOpenExrBitForBit) {
  const testing::ScratchFolder scratch;
  const fs::path path = scratch.path() / "a.exr";
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(23, 37), cv::Size(41, 16)}) {
    for (const Picture picture : {Picture::kNoise, Picture::kRamp, Picture::kUnknown}) {
      for (const PixelType type : {PixelType::kHalf, PixelType::kFloat}) {
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

TEST(ExrZipWrite, GivesTheSameBytesForTheSamePixels) {
  const testing::ScratchFolder scratch;
  const Image3 image = picture_of(Picture::kNoise, 200, 90);
  const auto bytes = [&](const char* name) {
    write_exr_rgb(scratch.path() / name, image, PixelType::kHalf);
    std::ifstream in(scratch.path() / name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  EXPECT_EQ(bytes("a.exr"), bytes("b.exr"));
}

// Failure: a full disk, which takes the header and nothing more.
TEST(ExrZipWrite, SaysWhatTheDiskDoesNotTake) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const Image1 image(64, 64, 0.5f);
  const std::vector<ExrSource> sources{
      {"Y", reinterpret_cast<const char*>(image.data), sizeof(float), image.step[0]}};
  try {
    write_zip("/dev/full", image.size(), sources, PixelType::kFloat);
    FAIL() << "written to a full disk";
  } catch (const std::exception& e) {
    EXPECT_NE(std::string(e.what()).find("No space left"), std::string::npos) << e.what();
  }
}

// Leaves numbers of its own on the stack, where the compressor's state will stand.
[[gnu::noinline]] int dirty_stack(uint16_t number) {
  volatile uint16_t left[1 << 17];
  for (volatile uint16_t& n : left) n = number;
  return left[number];
}

// Failure: a member of that state that nobody had set chose how far back matches are looked for.
TEST(ExrZipWrite, GivesTheSameBytesWhateverLayOnTheStackBefore) {
  const testing::ScratchFolder scratch;
  Image3 picture = picture_of(Picture::kNoise, 16, 400);
  for (Vec3& pixel : picture) pixel = Vec3::all(std::round(4 * pixel[0]));
  const auto written = [&](uint16_t before) {
    dirty_stack(before);
    write_exr_rgb(scratch.path() / "a.exr", picture);
    return read_text(scratch.path() / "a.exr");
  };
  const std::string first = written(0);
  for (const uint16_t before : {5, 9, 13}) EXPECT_TRUE(written(before) == first) << before;
}

}  // namespace
}  // namespace lamella
