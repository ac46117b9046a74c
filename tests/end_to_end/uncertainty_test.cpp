// Standard deviations are worth what the truth says they are: over noisy photographs of one subject
// a true figure lies within one of them about 68 % of the time.
#include <gtest/gtest.h>

#include "fit/layers.h"
#include "io/fake_session.h"
#include "io/whole_file.h"
#include "twin/session_writer.h"
#include "twin/truth_writer.h"

namespace lamella {
namespace {

constexpr int kSeeds = 5;

// How many true figures are within one, and two, of the deviations stated.
struct Coverage {
  int count = 0, within_one = 0, within_two = 0;

  void add(double found, double stddev, double truth) {
    ASSERT_GT(stddev, 0);
    const double sigmas = std::abs(found - truth) / stddev;
    ++count;
    within_one += sigmas < 1;
    within_two += sigmas < 2;
  }

  template <class Values>
  void add_all(const Values& found, const Values& stddev, const Values& truth) {
    for (int c = 0; c < 3; ++c) add(found[c], stddev[c], truth[c]);
  }

  // Neither too bold nor too shy. The figures of a region err together, so that few seeds are far
  // from 68 % by chance.
  void judge(const char* what) const {
    EXPECT_GT(within_one, 0.45 * count) << what;
    EXPECT_LT(within_one, 0.95 * count) << what;
    EXPECT_GT(within_two, 0.80 * count) << what;
    std::printf("%s: %d of %d within one sigma, %d within two\n", what, within_one, count,
                within_two);
  }
};

TEST(Uncertainty, TruthLiesWithinOneSigmaAboutTwoThirdsOfTheTime) {
  const testing::ScratchFolder scratch;
  twin::Photographer::Options options;
  options.subject = "sphere";
  options.scale = 0.3;
  options.noise = 3;
  options.photons = 20000;
  const twin::Photographer photographer(options);
  twin::write_truth(scratch.path() / "truth", photographer);
  const v1::Layers truth = read_layers(scratch.path() / "truth" / "layers.json");
  Coverage width, single, length;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    twin::Studio studio(photographer, seed);
    const fs::path folder = scratch.path() / std::to_string(seed);
    twin::write_session(folder, photographer, &studio);
    fs::copy_file(scratch.path() / "truth" / "regions.png", folder / "regions.png");
    const v1::Layers found = fit::fit_layers(read_session(folder), fit::Step::kAlbedo).layers;
    for (int r = 0; r < found.regions_size(); ++r) {
      const v1::Region &f = found.regions(r), &t = truth.regions(r);
      ASSERT_EQ(f.name(), t.name());
      width.add(f.specular().gaussian_m(), f.specular().gaussian_m_stddev(),
                t.specular().gaussian_m());
      single.add_all(f.single().amplitude(), f.single().amplitude_stddev(), t.single().amplitude());
      length.add_all(f.deep().ld_mm(), f.deep().ld_mm_stddev(), t.deep().ld_mm());
    }
  }
  width.judge("lobe width m");
  single.judge("single scattering");
  length.judge("l_d");
}

}  // namespace
}  // namespace lamella
