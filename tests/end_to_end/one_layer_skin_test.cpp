// A twin's skin that is one homogeneous layer is found to be that.
#include "end_to_end/hard_case.h"

namespace lamella {
namespace {

// Of a sphere with this skin.
v1::Layers layers_of(const std::string& skin) {
  const testing::ScratchFolder scratch;
  twin::Photographer::Options options;
  options.subject = "sphere";
  options.skin = skin;
  options.scale = 0.3;
  options.noise = 0.3;
  options.photons = 20000;
  const twin::Photographer photographer(options);
  twin::Studio studio(photographer, 1);
  twin::write_session(scratch.path() / "session", photographer, &studio);
  twin::write_truth(scratch.path() / "truth", photographer);
  fs::copy_file(scratch.path() / "truth" / "regions.png",
                scratch.path() / "session" / "regions.png");
  return fit::fit_layers(read_session(scratch.path() / "session"), fit::Step::kScattering).layers;
}

TEST(OneLayerSkin, IsFoundOutAndEveryRegionSaysWhatItsSlabStandsFor) {
  const v1::Layers layers = layers_of("one_layer");
  EXPECT_TRUE(layers.one_layer().found()) << layers.one_layer().why();
  ASSERT_GT(layers.regions_size(), 0);
  for (const v1::Region& region : layers.regions()) {
    const std::string why = region.layers().why().at("shallow");
    EXPECT_TRUE(region.layers().shallow()) << region.name();
    EXPECT_NE(why.find("found to be one homogeneous layer"), std::string::npos)
        << region.name() << ": " << why;
  }
}

}  // namespace
}  // namespace lamella
