#include "fit/channel_fit.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lamella::fit {
namespace {

constexpr size_t kGroups = 8;
constexpr size_t kNear = 16, kFar = 22;  // lengths of about 0.4 and 1 mm
const KnownSkin kKnown{{}, {0.5, 0.2}};

// `moved` of all light goes further than it did.
ExponentialMixture mixture_of(double moved) {
  ExponentialMixture kernel;
  kernel.weight[kNear] = 0.55 - moved;
  kernel.weight[kFar] = 0.45 + moved;
  return kernel;
}

ChannelTails tails_that_differ(double moved) {
  ChannelTails tails;
  tails.kernels.all = tails.kernels.more_blurred = mixture_of(0);
  tails.all.ld_mm = 1;
  tails.all.transport_mm = 0.32;
  tails.more_blurred = tails.all;
  for (size_t g = 0; g < kGroups; ++g) {
    tails.kernels.without_group.push_back(mixture_of(g % 2 ? moved : -moved));
    tails.without_group.push_back(tails.all);
  }
  return tails;
}

// Failure: dots that differ by much move a slab's figures along a bent valley, and deviations were
// taken from its first part alone.
TEST(ChannelFit, DeviationsOfASlabAreWhatAnotherDrawOfAllItsDotsMakesOfIt) {
  const double moved = 0.06, of_a_draw = moved * std::sqrt(kGroups - 1.0);
  const ChannelTails tails = tails_that_differ(moved);
  const LayeredProfile start = fit_layered_profiles(tails.kernels.all, tails.all, kKnown)[1];
  LayeredProfile found = start;
  found.shallow_ld_mm_stddev = found.shallow_alpha_stddev = 0;
  widen_layers(tails, kKnown, &found);
  double square_mm2 = 0;
  for (const double sign : {-1.0, 1.0}) {
    const LayeredProfile other =
        refine_layered_profile(mixture_of(sign * of_a_draw), tails.all, kKnown, start);
    square_mm2 += std::pow(other.shallow_ld_mm - start.shallow_ld_mm, 2) / 2;
  }
  EXPECT_GT(found.shallow_ld_mm_stddev, 0.02);
  EXPECT_NEAR(found.shallow_ld_mm_stddev / std::sqrt(square_mm2), 1, 0.02);
}

TEST(ChannelFit, DotsThatAreAllAlikeLeaveDeviationsAsTheyWere) {
  const ChannelTails tails = tails_that_differ(0);
  LayeredProfile layers = fit_layered_profiles(tails.kernels.all, tails.all, kKnown)[1];
  const double own = layers.shallow_ld_mm_stddev;
  widen_layers(tails, kKnown, &layers);
  EXPECT_NEAR(layers.shallow_ld_mm_stddev / own, 1, 0.05);
}

}  // namespace
}  // namespace lamella::fit
