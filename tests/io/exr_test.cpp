#include "io/exr.h"

#include <opencv2/core/cvdef.h>

#include <fstream>

#include "io/expect_error.h"
#include "io/fake_session.h"

namespace lamella {
namespace {

using testing::complaint;
using testing::names;
using testing::ScratchFolder;

Image3 noise_image(int rows, int cols) {
  Image3 image(rows, cols);
  cv::RNG random(7);
  for (Vec3& v : image) v = Vec3(random.uniform(-1.f, 4.f), random.uniform(0.f, 1e-3f), 1e4f);
  return image;
}

TEST(Exr, KeepsFloatsExactly) {
  const ScratchFolder scratch;
  const Image3 image = noise_image(37, 23);
  write_exr_rgb(scratch.path() / "a.exr", image);
  EXPECT_EQ(cv::norm(image, read_exr_rgb(scratch.path() / "a.exr"), cv::NORM_INF), 0);
  EXPECT_EQ(exr_size(scratch.path() / "a.exr"), cv::Size(23, 37));
}

TEST(Exr, RoundsToTheNearestHalf) {
  const ScratchFolder scratch;
  const Image3 image = noise_image(37, 23);
  write_exr_rgb(scratch.path() / "a.exr", image, PixelType::kHalf);
  const Image3 back = read_exr_rgb(scratch.path() / "a.exr");
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      for (int c = 0; c < 3; ++c) {
        ASSERT_EQ(back(y, x)[c], float(cv::float16_t(image(y, x)[c])));
      }
    }
  }
}

TEST(Exr, KeepsWhatIsNotKnown) {
  const ScratchFolder scratch;
  Image3 image = noise_image(4, 4);
  image(2, 1) = Vec3(kNaN, kNaN, kNaN);
  for (const PixelType type : {PixelType::kHalf, PixelType::kFloat}) {
    write_exr_xyz(scratch.path() / "a.exr", image, type);
    EXPECT_FALSE(is_finite(read_exr_xyz(scratch.path() / "a.exr")(2, 1)));
  }
}

TEST(Exr, ReadsChannelsByNameInTheOrderAskedFor) {
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "a.exr";
  write_exr(file, {{"alpha", Image1(3, 5, 1.f)}, {"beta", Image1(3, 5, 2.f)}});
  EXPECT_EQ(exr_channels(file), (std::vector<std::string>{"alpha", "beta"}));
  const auto planes = read_exr(file, {"beta", "alpha"});
  EXPECT_EQ(planes[0](2, 4), 2.f);
  EXPECT_EQ(planes[1](2, 4), 1.f);
  EXPECT_TRUE(names(complaint([&] { read_exr(file, {"gamma"}); }), {"a.exr", "no channel gamma"}));
}

TEST(Exr, RefusesAFileCutAnywhere) {
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "a.exr";
  write_exr_rgb(file, noise_image(64, 64), PixelType::kHalf);
  const auto whole = fs::file_size(file);
  for (const double share : {0.99, 0.6, 0.2, 0.02, 0.0}) {
    fs::resize_file(file, uintmax_t(double(whole) * share));
    EXPECT_TRUE(names(complaint([&] { read_exr_rgb(file); }), {"a.exr"})) << share;
  }
}

TEST(Exr, NamesAFileThatIsCutOnce) {
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "a.exr";
  write_exr_rgb(file, noise_image(64, 64), PixelType::kHalf);
  fs::resize_file(file, fs::file_size(file) / 2);
  const std::string line = complaint([&] { read_exr_rgb(file); });
  EXPECT_EQ(line.find("a.exr"), line.rfind("a.exr")) << line;
}

TEST(Exr, RefusesWhatIsNotAnExrFile) {
  const ScratchFolder scratch;
  std::ofstream(scratch.path() / "text.exr") << "a letter, not a photograph";
  for (const char* name : {"text.exr", "missing.exr", "."}) {
    const fs::path file = scratch.path() / name;
    EXPECT_TRUE(names(complaint([&] { read_exr_rgb(file); }), {file.string()})) << name;
  }
}

// OpenEXR itself would allocate the two gigabytes first.
TEST(Exr, RefusesAnAttributeLongerThanTheFile) {
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "a.exr";
  const std::string header("\x76\x2f\x31\x01\x02\0\0\0note\0string\0\xff\xff\xff\x7f", 24);
  std::ofstream(file, std::ios::binary) << header << "short";
  EXPECT_TRUE(names(complaint([&] { read_exr_rgb(file); }), {"a.exr", "\"note\" is cut"}));
}

TEST(Exr, LeavesNothingBehindWhereItCannotWrite) {
  const ScratchFolder scratch;
  std::ofstream(scratch.path() / "file") << "in the way";
  const fs::path place = scratch.path() / "file" / "a.exr";
  EXPECT_TRUE(names(complaint([&] { write_exr_rgb(place, noise_image(2, 2)); }), {"a.exr"}));
  EXPECT_EQ(scratch.contents(), std::set<std::string>{"file"});
}

TEST(Exr, RefusesToWritePlanesOfDifferentSizes) {
  const ScratchFolder scratch;
  EXPECT_NE(complaint([&] {
              write_exr(scratch.path() / "a.exr", {{"a", Image1(3, 5)}, {"b", Image1(2, 5)}});
            }),
            "");
  EXPECT_TRUE(scratch.contents().empty());
}

}  // namespace
}  // namespace lamella
