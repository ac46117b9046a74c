#include "io/layer_maps.h"

#include "io/expect_error.h"
#include "io/fake_session.h"
#include "io/whole_file.h"

namespace lamella {
namespace {

using testing::complaint;
using testing::names;
using testing::ScratchFolder;

Image3 plane(float base) {
  Image3 image(5, 4);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 4; ++x) image(y, x) = Vec3(base + float(x), float(y), base);
  }
  image(0, 0) = Vec3(kNaN, kNaN, kNaN);
  return image;
}

LayerMaps all_maps() {
  LayerMaps m;
  m.position_mm = plane(1);
  m.normal_specular = plane(2);
  for (int c = 0; c < 3; ++c) m.normal_diffuse[c] = plane(3 + float(c));
  m.specular_intensity = Image1(5, 4, 0.25f);
  m.single_albedo = plane(6);
  m.total_albedo = plane(7);
  m.shallow_albedo = plane(8);
  m.deep_albedo = plane(9);
  m.deep_alpha = plane(10);
  m.deep_ld_mm = plane(11);
  m.confidence["position"] = Image1(5, 4, 0.5f);
  m.stddev["deep_albedo.R"] = Image1(5, 4, 0.0123f);
  m.regions = Labels(5, 4, uchar(3));
  return m;
}

bool same(const Image3& a, const Image3& b) {
  if (a.size() != b.size()) return false;
  return std::memcmp(a.data, b.data, a.total() * sizeof(Vec3)) == 0 || [&] {
    for (int y = 0; y < a.rows; ++y) {
      for (int x = 0; x < a.cols; ++x) {
        const bool unknown = !is_finite(a(y, x)) && !is_finite(b(y, x));
        if (!unknown && a(y, x) != b(y, x)) return false;
      }
    }
    return true;
  }();
}

bool same_values(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat3f a3, b3;
  cv::merge(std::vector<cv::Mat>(3, a), a3);
  cv::merge(std::vector<cv::Mat>(3, b), b3);
  return same(a3, b3);
}

TEST(LayerMaps, OfAWindowComeBackInTheWholeImageWithNothingKnownAround) {
  const ScratchFolder scratch;
  LayerMaps maps = all_maps();
  maps.window = PixelWindow{{9, 40}, {3, 20, 4, 5}};
  write_layer_maps(scratch.path(), maps);
  const LayerMaps back = read_layer_maps(scratch.path());
  const auto whole = named_maps(back), part = named_maps(maps);
  for (size_t i = 0; i < whole.size(); ++i) {
    std::vector<cv::Mat> planes, own;
    cv::split(whole[i].second, planes);
    cv::split(part[i].second, own);
    for (size_t c = 0; c < planes.size(); ++c) {
      ASSERT_EQ(planes[c].size(), maps.window->whole);
      EXPECT_TRUE(same_values(planes[c](maps.window->area), own[c])) << whole[i].first;
      planes[c](maps.window->area).setTo(kNaN);
      EXPECT_EQ(cv::countNonZero(planes[c] == planes[c]), 0) << whole[i].first;
    }
  }
  Image1 confidence = back.confidence.at("position");
  EXPECT_EQ(cv::sum(confidence)[0], cv::sum(maps.confidence.at("position"))[0]);
  EXPECT_EQ(cv::countNonZero(confidence != confidence), 0);
  EXPECT_EQ(cv::sum(back.regions)[0], cv::sum(maps.regions)[0]);
}

TEST(LayerMaps, ComeBackAsTheyWereWritten) {
  const ScratchFolder scratch;
  const LayerMaps maps = all_maps();
  write_layer_maps(scratch.path(), maps);
  const LayerMaps back = read_layer_maps(scratch.path());
  EXPECT_TRUE(same(back.position_mm, maps.position_mm));
  EXPECT_TRUE(same(back.normal_specular, maps.normal_specular));
  for (int c = 0; c < 3; ++c) EXPECT_TRUE(same(back.normal_diffuse[c], maps.normal_diffuse[c]));
  EXPECT_TRUE(same(back.single_albedo, maps.single_albedo));
  EXPECT_TRUE(same(back.total_albedo, maps.total_albedo));
  EXPECT_TRUE(same(back.shallow_albedo, maps.shallow_albedo));
  EXPECT_TRUE(same(back.deep_albedo, maps.deep_albedo));
  EXPECT_TRUE(same(back.deep_alpha, maps.deep_alpha));
  EXPECT_TRUE(same(back.deep_ld_mm, maps.deep_ld_mm));
  EXPECT_EQ(back.specular_intensity(4, 3), 0.25f);
  EXPECT_EQ(back.confidence.at("position")(4, 3), 0.5f);
  EXPECT_EQ(back.regions(4, 3), 3);
}

TEST(LayerMaps, HaveTheChannelNamesOfTheFormat) {
  const ScratchFolder scratch;
  write_layer_maps(scratch.path(), all_maps());
  using Channels = std::vector<std::string>;
  EXPECT_EQ(exr_channels(scratch.path() / "position.exr"), (Channels{"X", "Y", "Z"}));
  EXPECT_EQ(exr_channels(scratch.path() / "specular_intensity.exr"), Channels{"Y"});
  EXPECT_EQ(exr_channels(scratch.path() / "deep_ld.exr"), (Channels{"B", "G", "R"}));
  EXPECT_EQ(exr_channels(scratch.path() / "normal_diffuse.exr").size(), 9u);
  EXPECT_EQ(exr_channels(scratch.path() / "confidence.exr"), Channels{"position"});
  EXPECT_EQ(exr_channels(scratch.path() / "stddev.exr"), Channels{"deep_albedo.R"});
}

TEST(LayerMaps, KeepDeviationsToThreePercent) {
  const ScratchFolder scratch;
  LayerMaps maps = all_maps();
  Image1& stddev = maps.stddev["deep_albedo.R"];
  stddev(0, 0) = kNaN;
  for (int x = 1; x < 4; ++x) stddev(0, x) = std::pow(10.f, float(-x)) * 1.37f;
  write_layer_maps(scratch.path(), maps);
  const Image1 back = read_exr(scratch.path() / "stddev.exr", {"deep_albedo.R"})[0];
  EXPECT_TRUE(std::isnan(back(0, 0)));
  for (int x = 1; x < 4; ++x) EXPECT_NEAR(back(0, x) / stddev(0, x), 1, 0.016);
}

TEST(LayerMaps, MustAllShowTheSamePixels) {
  const ScratchFolder scratch;
  LayerMaps maps = all_maps();
  maps.deep_albedo = Image3(4, 4, Vec3(0, 0, 0));
  write_layer_maps(scratch.path(), maps);
  EXPECT_TRUE(names(complaint([&] { read_layer_maps(scratch.path()); }),
                    {"deep_albedo.exr", "4x4", "4x5"}));
}

TEST(LayerMaps, NeedPositionsAndNormals) {
  const ScratchFolder scratch;
  LayerMaps maps = all_maps();
  maps.normal_specular = Image3();
  write_layer_maps(scratch.path(), maps);
  EXPECT_TRUE(names(complaint([&] { read_layer_maps(scratch.path()); }), {"normal_specular.exr"}));
}

TEST(Layers, MayHoldFiguresThatAreNotKnown) {
  const ScratchFolder scratch;
  write_whole_text(scratch.path() / "layers.json",
                   R"({"format": "lamella.layers.v1",
                       "regions": [{"name": "lips", "deep": {"ld_mm": [1, "NaN", 2]}}]})");
  const v1::Layers layers = read_layers(scratch.path() / "layers.json");
  EXPECT_TRUE(std::isnan(layers.regions(0).deep().ld_mm(1)));
}

}  // namespace
}  // namespace lamella
