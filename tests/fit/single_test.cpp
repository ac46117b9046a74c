#include <gtest/gtest.h>

#include "fit/phase_asymmetry.h"
#include "model/single_scattering.h"

namespace lamella::fit {
namespace {

TEST(PhaseAsymmetry, UndoesTheAmplitudeThatGMade) {
  const double reduced = 0.9;
  for (double g : {0.3, 0.65, 0.7, 0.9}) {
    const double albedo = 1 / (1 + (1 - g) * (1 / reduced - 1));
    const double amplitude = model::amplitude_from_alpha(albedo / model::kAlbedoPerAlpha, g);
    EXPECT_NEAR(asymmetry_of(amplitude, reduced), g, 1e-6);
  }
}

TEST(PhaseAsymmetry, StaysAtTheBoundsForAmplitudesThatNoGGives) {
  EXPECT_NEAR(asymmetry_of(10, 0.9), 0, 1e-6);
  EXPECT_GT(asymmetry_of(0, 0.9), 0.98);
}

TEST(PhaseAsymmetry, SaysWhatItAssumesAndHowWellItKnows) {
  RegionFit fit = prior_region_fit();
  fit.single.fitted = true;
  fit.single.amplitude = {0.067, 0.0635, 0.053};
  fit.diffuse_reflectance = {0.5, 0.35, 0.25};
  const PhaseAsymmetry a = estimate_asymmetry({fit});
  EXPECT_FALSE(a.assumes.empty());
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_GT(a.g[c], 0.55);
    EXPECT_LT(a.g[c], 0.8);
    EXPECT_GT(a.g_stddev[c], 0.005);
  }
}

TEST(PhaseAsymmetry, WithoutSingleScatteringIsTheTypicalOneWithALargeDeviation) {
  const PhaseAsymmetry a = estimate_asymmetry({prior_region_fit()});
  EXPECT_NEAR(a.g[0], 0.65, 1e-9);
  EXPECT_GE(a.g_stddev[0], 0.1);
}

RegionFit with_single(double amplitude, double stddev) {
  RegionFit fit = prior_region_fit();
  fit.lobe.fitted = true;
  fit.samples = 1000;
  fit.measured_single.fill(amplitude);
  fit.single.amplitude_stddev.fill(stddev);
  return fit;
}

// Failure: a region that is seen badly has an amplitude of its own, and its c and lobe follow it;
// or it alone has none, as if it were other skin.
TEST(SharedSingle, IsTheMeanByInverseVarianceOfAllRegionsAndOfThoseThatAreSeenBadlyToo) {
  std::vector<RegionFit> fits{with_single(0.068, 0.001), with_single(0.048, 0.003),
                              with_single(0.01, 0.05)};
  share_single(&fits);
  for (const RegionFit& fit : fits) {
    EXPECT_TRUE(fit.single.fitted);
    EXPECT_NEAR(fit.single.amplitude[1], 0.066, 1e-4);
    EXPECT_GT(fit.single.amplitude_stddev[1], 0.005);
    EXPECT_TRUE(fit.single.why.starts_with("kept: ")) << fit.single.why;
  }
}

// Failure: of many regions without any, chance shows it in one, and all take it.
TEST(SharedSingle, IsNoneWhereRegionsTogetherShowNone) {
  std::vector<RegionFit> fits{with_single(0.006, 0.001), with_single(0.0005, 0.0005),
                              with_single(0, 0.001)};
  share_single(&fits);
  for (const RegionFit& fit : fits) {
    EXPECT_FALSE(fit.single.fitted);
    EXPECT_EQ(fit.single.amplitude[1], 0);
    EXPECT_EQ(fit.single.doubt, Doubt::kNone);
    EXPECT_TRUE(fit.single.why.starts_with("dropped: an amplitude of 0.00")) << fit.single.why;
  }
}

// Failure: what is wrong with the white light of the surface counts three times, once a channel.
TEST(SharedSingle, IsNotSeenWhereEachChannelHasTwoSigmas) {
  std::vector<RegionFit> fits{with_single(0.012, 0.005)};
  share_single(&fits);
  EXPECT_FALSE(fits[0].single.fitted);
}

}  // namespace
}  // namespace lamella::fit
