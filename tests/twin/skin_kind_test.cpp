// The kinds of skin: what each leaves out or changes, in its photographs and in its truth alike.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <memory>

#include "base/error.h"
#include "io/layer_maps.h"
#include "twin/studio.h"
#include "twin/truth_maps.h"
#include "twin/truth_writer.h"

namespace lamella::twin {
namespace {

const Photographer& small_sphere(const std::string& skin) {
  static std::map<std::string, std::unique_ptr<Photographer>> made;
  std::unique_ptr<Photographer>& sphere = made[skin];
  if (!sphere) {
    sphere = std::make_unique<Photographer>(Photographer::Options{.subject = "sphere",
                                                                  .skin = skin,
                                                                  .seed = 1,
                                                                  .scale = 0.12,
                                                                  .photons = 3000,
                                                                  .spacing_mm = 0.8f});
  }
  return *sphere;
}

class Folder {
 public:
  Folder() { fs::create_directories(path_); }
  ~Folder() { fs::remove_all(path_); }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_ = fs::temp_directory_path() / ("skins_" + std::to_string(::getpid()));
};

TEST(SkinKind, ThatIsUnknownIsRefusedInALineThatListsThoseThereAre) {
  try {
    skin_kind("green");
    FAIL();
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(),
                 "--skin: \"green\"; the twin knows layered, one_layer, no_single, dark and light");
  }
}

TEST(SkinKind, IsNamedByTheSubjectOfASessionUnlessItIsTheUsual) {
  EXPECT_EQ(small_sphere("layered").rig().subject, "sphere");
  EXPECT_EQ(small_sphere("no_single").rig().subject, "sphere-no_single");
}

TEST(LayeredSkin, IsWhatTheTwinHadBeforeItKnewOthers) {
  EXPECT_EQ(Photographer::Options{}.skin, "layered");
  const Skin nose = facial_skins(1, skin_kind("layered"))[2];
  const SlabOptics green = slab_of(nose, 1);
  EXPECT_FLOAT_EQ(green.upper.absorption_per_mm, 0.224300414f);
  EXPECT_FLOAT_EQ(green.upper.scattering_per_mm, 12.121213f);
  EXPECT_FLOAT_EQ(green.upper.thickness_mm, 0.20307456f);
  EXPECT_FLOAT_EQ(green.lower.absorption_per_mm, 0.183927417f);
  EXPECT_FLOAT_EQ(green.lower.scattering_per_mm, 7.87878799f);
  EXPECT_FLOAT_EQ(nose.roughness, 0.219335347f);
  EXPECT_FLOAT_EQ(nose.intensity, 0.327966601f);
  EXPECT_FLOAT_EQ(single_albedo(nose, 1), 0.515559435f);
}

TEST(OneLayerSkin, ReturnsNoShallowLight) {
  for (const auto& region : small_sphere("one_layer").profiles()) {
    for (const Profile& profile : region) {
      EXPECT_EQ(profile.shallow_total, 0.0);
      EXPECT_EQ(*std::max_element(profile.shallow.begin(), profile.shallow.end()), 0.f);
      EXPECT_GT(profile.deep_total, 0.1);
      EXPECT_GT(profile.single_total, 0.0);
    }
  }
}

TEST(OneLayerSkin, ScattersOnceAsItsDermisDoes) {
  const Skin skin = facial_skins(1, SkinKind::kOneLayer)[0];
  const LayerOptics dermis = slab_of(skin, 2).lower;
  EXPECT_FLOAT_EQ(single_albedo(skin, 2),
                  dermis.scattering_per_mm / (dermis.scattering_per_mm + dermis.absorption_per_mm) /
                      (kIor * kIor));
}

TEST(OneLayerSkin, HasATruthWithoutAShallowLayer) {
  const Folder folder;
  write_truth(folder.path(), small_sphere("one_layer"));
  const v1::Layers layers = read_layers(folder.path() / "layers.json");
  for (const v1::Region& region : layers.regions()) {
    EXPECT_FALSE(region.has_shallow());
    EXPECT_FALSE(region.layers().shallow());
    EXPECT_TRUE(region.layers().specular() && region.layers().single() && region.layers().deep());
    EXPECT_NE(region.layers().why().at("shallow"), "");
  }
  const Image3 shallow = read_exr_rgb(folder.path() / "shallow_albedo_physical.exr");
  const Image3 deep = read_exr_rgb(folder.path() / "deep_albedo_physical.exr");
  const Vec3 in_front = shallow(shallow.rows / 2, shallow.cols / 2);
  EXPECT_EQ(in_front, Vec3(0, 0, 0));
  EXPECT_GT(deep(deep.rows / 2, deep.cols / 2)[0], 0.2f);
}

TEST(SkinWithoutSingleScattering, CountsNoneAmongWhatCameBack) {
  for (const auto& region : small_sphere("no_single").profiles()) {
    for (const Profile& profile : region) EXPECT_EQ(profile.single_total, 0.0);
  }
}

TEST(SkinWithoutSingleScattering, HasATruthWithoutItToo) {
  const Folder folder;
  write_truth(folder.path(), small_sphere("no_single"));
  const v1::Layers layers = read_layers(folder.path() / "layers.json");
  for (const v1::Region& region : layers.regions()) {
    for (double amplitude : region.single().amplitude()) EXPECT_EQ(amplitude, 0.0);
    EXPECT_FALSE(region.layers().single());
    EXPECT_TRUE(region.layers().specular() && region.layers().shallow() && region.layers().deep());
    EXPECT_NE(region.layers().why().at("single"), "");
  }
  const LayerMaps truth = read_layer_maps(folder.path());
  EXPECT_EQ(truth.single_albedo(truth.regions.rows / 2, truth.regions.cols / 2), Vec3(0, 0, 0));
}

// FRONT parallel less cross, as the left camera sees it without noise.
Image3 front_difference(const Photographer& photographer) {
  Studio studio(photographer, 1);
  const LightState white{.codes = {}, .pattern = v1::PatternSpan::WHITE, .index = 0};
  return studio.radiance({0, {{white, 1.0, 0.5}}}) - studio.radiance({0, {{white, 0.0, 0.5}}});
}

TEST(SkinWithoutSingleScattering, KeepsNoPolarizationBesideTheHighlights) {
  const Receivers& r = small_sphere("layered").receivers(Eye::kLeft);
  const Image3 with = front_difference(small_sphere("layered"));
  const Image3 without = front_difference(small_sphere("no_single"));
  const PointLight& projector = small_sphere("layered").projector();
  int beside = 0;
  for (size_t i = 0; i < r.size(); ++i) {
    const Vec3 l = projector.direction(r.targets.position_mm[i]), n = r.shading_normal[i];
    // The surface returns nothing where only facets 60 degrees from the normal are mirrors.
    if (dot(n, unit(l + r.to_camera[i])) > 0.5f || dot(n, l) < 0.2f) continue;
    if (!projector.sees(r.targets.position_mm[i], r.normal[i])) continue;
    ++beside;
    const int y = r.pixel[i] / r.width, x = r.pixel[i] % r.width;
    EXPECT_GT(with(y, x)[1], 1e-3f);
    EXPECT_NEAR(without(y, x)[1], 0.f, 1e-6f);
  }
  EXPECT_GT(beside, 20);
}

struct Albedos {
  double deep = 0, shallow = 0;  // mean over labelled pixels and channels
};

Albedos albedos_of(const std::string& skin) {
  const Photographer& photographer = small_sphere(skin);
  const LayerMaps maps = truth_maps(photographer, region_truth(photographer.profiles())).maps;
  Albedos sum;
  int count = 0;
  for (int y = 0; y < maps.regions.rows; ++y) {
    for (int x = 0; x < maps.regions.cols; ++x) {
      if (!maps.regions(y, x) || !is_finite(maps.deep_albedo(y, x))) continue;
      sum.deep += dot(maps.deep_albedo(y, x), Vec3::all(1.f / 3));
      sum.shallow += dot(maps.shallow_albedo(y, x), Vec3::all(1.f / 3));
      ++count;
    }
  }
  return {sum.deep / count, sum.shallow / count};
}

TEST(DarkSkin, HasADeepAlbedoOfATwentieth) { EXPECT_NEAR(albedos_of("dark").deep, 0.05, 0.007); }

TEST(LightSkin, ReflectsHalfOfTheLight) {
  const Albedos light = albedos_of("light");
  EXPECT_NEAR(light.deep + light.shallow, 0.5, 0.05);
}

TEST(DarkAndLightSkin, DifferFromTheUsualByWhatTheyAbsorbAlone) {
  const Skin usual = facial_skins(1)[0];
  for (SkinKind kind : {SkinKind::kDark, SkinKind::kLight}) {
    const Skin skin = facial_skins(1, kind)[0];
    EXPECT_EQ(skin.epidermis_reduced_scattering_per_mm, usual.epidermis_reduced_scattering_per_mm);
    EXPECT_EQ(skin.dermis_reduced_scattering_per_mm, usual.dermis_reduced_scattering_per_mm);
    EXPECT_EQ(skin.epidermis_mm, usual.epidermis_mm);
    EXPECT_EQ(skin.intensity, usual.intensity);
    EXPECT_NE(skin.epidermis_absorption_per_mm, usual.epidermis_absorption_per_mm);
  }
}

}  // namespace
}  // namespace lamella::twin
