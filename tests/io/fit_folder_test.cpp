// A fit that is not whole is refused in one line that names the file and the field.
#include "io/fit_folder.h"

#include <fstream>
#include <functional>

#include "io/expect_error.h"
#include "io/fake_fit.h"
#include "io/fake_session.h"
#include "io/whole_file.h"

namespace lamella {
namespace {

using testing::complaint;
using testing::names;
using testing::ScratchFolder;

const cv::Size kSize(24, 32);

class AFit : public ::testing::Test {
 protected:
  AFit() { testing::write_fake_fit(path(), kSize); }

  fs::path path() const { return scratch_.path() / "fit"; }
  std::string reading() const {
    return complaint([&] { read_fit_folder(path()); });
  }

  std::string with_layers(const std::function<void(v1::Layers*)>& spoil) const {
    v1::Layers layers = testing::fake_layers();
    spoil(&layers);
    write_json(path() / "layers.json", layers);
    return reading();
  }

  void drop_deep(const std::string& why) const {
    v1::Layers layers = testing::fake_layers();
    for (v1::Region& region : *layers.mutable_regions()) {
      region.clear_deep();
      region.mutable_layers()->set_deep(false);
      if (!why.empty()) (*region.mutable_layers()->mutable_why())["deep"] = why;
    }
    write_json(path() / "layers.json", layers);
  }

  ScratchFolder scratch_;
};

TEST_F(AFit, ReadsAsItWasWritten) {
  const FitFolder fit = read_fit_folder(path());
  EXPECT_EQ(fit.maps.position_mm.size(), kSize);
  EXPECT_EQ(fit.layers.regions_size(), 2);
}

TEST_F(AFit, NeedsEveryMap) {
  for (const char* map :
       {"position", "normal_specular", "normal_diffuse", "specular_intensity", "single_albedo",
        "shallow_albedo", "deep_albedo", "total_albedo", "deep_alpha", "deep_ld"}) {
    testing::write_fake_fit(path(), kSize);
    fs::remove(path() / (std::string(map) + ".exr"));
    EXPECT_TRUE(names(reading(), {std::string(map) + ".exr: missing", "run fit to its end"}));
  }
}

TEST_F(AFit, NeedsANumberInEveryMap) {
  for (const char* map : {"position", "normal_specular"}) {
    testing::write_fake_fit(path(), kSize);
    write_exr_xyz(path() / (std::string(map) + ".exr"), Image3(kSize, Vec3::all(kNaN)));
    EXPECT_TRUE(names(reading(), {std::string(map) + ".exr: no labelled pixel has a number"}));
  }
  testing::write_fake_fit(path(), kSize);
  write_exr_rgb(path() / "deep_albedo.exr", Image3(kSize, Vec3::all(kNaN)));
  EXPECT_TRUE(names(reading(), {"deep_albedo.exr: no labelled pixel has a number"}));
}

TEST_F(AFit, HasMapsOfOneSize) {
  write_exr_rgb(path() / "total_albedo.exr", Image3(cv::Size(20, 30), Vec3::all(0.5f)));
  EXPECT_TRUE(names(reading(), {"total_albedo.exr", "20x30", "24x32"}));
}

TEST_F(AFit, NeedsLabelsThatItsRegionsHave) {
  write_whole_text(path() / "regions.png", "twenty photographs");
  EXPECT_TRUE(names(reading(), {"regions.png: not a PNG image"}));
  LayerMaps maps = testing::fake_maps(kSize);
  maps.regions(5, 5) = 9;
  write_layer_maps(path(), maps);
  EXPECT_TRUE(names(reading(), {"regions.png: label 9", "2 regions"}));
  maps.regions = Labels(kSize, uchar(0));
  write_layer_maps(path(), maps);
  EXPECT_TRUE(names(reading(), {"regions.png: no pixel is labelled"}));
}

TEST_F(AFit, NamesTheRegionAndTheLayerThatIsMissing) {
  EXPECT_TRUE(
      names(with_layers([](v1::Layers* l) { l->mutable_regions(1)->clear_deep(); }),
            {"layers.json: regions[1].deep: missing, though layers.deep is true", "run fit"}));
  EXPECT_TRUE(names(with_layers([](v1::Layers* l) {
                      l->mutable_regions(0)->clear_deep();
                      l->mutable_regions(0)->clear_layers();
                    }),
                    {"regions[0].deep: missing", "run fit to its end"}));
}

TEST_F(AFit, NamesTheFigureThatMakesNoSense) {
  EXPECT_TRUE(names(
      with_layers([](v1::Layers* l) { l->mutable_regions(1)->mutable_deep()->set_ld_mm(2, -1); }),
      {"regions[1].deep.ld_mm", "positive"}));
  EXPECT_TRUE(names(with_layers([](v1::Layers* l) {
                      l->mutable_regions(0)->mutable_deep()->mutable_alpha_dot()->Truncate(2);
                    }),
                    {"regions[0].deep.alpha_dot", "three numbers"}));
  EXPECT_TRUE(names(with_layers([](v1::Layers* l) {
                      l->mutable_regions(0)->mutable_specular()->mutable_p()->Truncate(3);
                    }),
                    {"regions[0].specular.p", "3 numbers"}));
  EXPECT_TRUE(names(with_layers([](v1::Layers* l) {
                      l->mutable_regions(0)->mutable_specular()->set_theta(1, 0);
                    }),
                    {"regions[0].specular.theta", "do not increase"}));
  EXPECT_TRUE(names(with_layers([](v1::Layers* l) { l->mutable_regions(1)->set_name("skin"); }),
                    {"regions[1].name", "skin"}));
}

TEST_F(AFit, MayDropALayerForAReasonThatItStates) {
  drop_deep("no dot of the pattern lies on it");
  fs::remove(path() / "deep_ld.exr");
  write_exr_rgb(path() / "deep_alpha.exr", Image3(kSize, Vec3::all(kNaN)));
  const FitFolder fit = read_fit_folder(path());
  EXPECT_TRUE(fit.maps.deep_ld_mm.empty());
  EXPECT_TRUE(fit.maps.deep_alpha.empty());
  EXPECT_FALSE(fit.maps.deep_albedo.empty());
}

TEST_F(AFit, MayNotDropALayerWithoutAReason) {
  drop_deep("");
  EXPECT_TRUE(names(reading(), {"regions[0].deep: missing", "gives no reason"}));
}

// Failure: whatever stood in a map was drawn, and exported.
TEST_F(AFit, HasNoNumberThatNoFitGives) {
  const auto with = [&](const std::string& map, Vec3 value) {
    LayerMaps maps = testing::fake_maps(kSize);
    for (const auto& [name, values] : named_maps(maps)) {
      if (name != map) continue;
      cv::Mat3f pixels = values;  // the same
      pixels(16, 12) = value;
    }
    write_layer_maps(path(), maps);
    return reading();
  };
  EXPECT_TRUE(names(with("deep_albedo", {0.5f, -5, 0.5f}),
                    {"deep_albedo.exr: has, at pixel (12, 16), -5", "fit again"}));
  EXPECT_TRUE(names(with("total_albedo", {0.5f, 0.5f, 7}), {"total_albedo.exr", "(12, 16), 7"}));
  EXPECT_TRUE(names(with("normal_specular", {0, 0, 2}), {"a normal of length 2"}));
  EXPECT_TRUE(names(with("normal_diffuse", {0, 0, 0}), {"normal_diffuse.exr", "of length 0"}));
  EXPECT_TRUE(names(with("deep_alpha", {1.5f, 1, 1}), {"deep_alpha.exr", "(12, 16), 1.5"}));
  EXPECT_TRUE(names(with("deep_ld", {1, 1, -0.5f}), {"deep_ld.exr", "(12, 16), -0.5"}));
  EXPECT_TRUE(names(with("position", {1, HUGE_VALF, 1}), {"position.exr", "(12, 16), inf"}));
  EXPECT_EQ(with("deep_albedo", Vec3::all(kNaN)), "");
}

TEST_F(AFit, HasANumberWhereItIsConfident) {
  LayerMaps maps = testing::fake_maps(kSize);
  maps.confidence["deep_albedo"] = Image1(kSize, 0.f);
  maps.deep_albedo(16, 12) = Vec3::all(kNaN);
  write_layer_maps(path(), maps);
  EXPECT_EQ(reading(), "");
  maps.confidence["deep_albedo"](16, 12) = 0.5f;
  write_layer_maps(path(), maps);
  EXPECT_TRUE(names(reading(), {"deep_albedo.exr", "(12, 16)", "confidence.exr"}));
}

}  // namespace
}  // namespace lamella
