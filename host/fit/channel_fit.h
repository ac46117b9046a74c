// What the dots of one region say of one channel: the tail of its kernel, then both layers.
#pragma once

#include <vector>

#include "fit/dot_measure.h"
#include "fit/exponential_mixture.h"
#include "fit/layer_choice.h"
#include "fit/layer_profile.h"

namespace lamella::fit {

// What camera and projector blur.
struct PatternBlur {
  double agreed_mm = 0;       // one sigma, what all kernels agree on
  cv::Mat1d agreed, doubted;  // blurred exponentials: by that, by one sigma of it more
};

PatternBlur pattern_blur(const Session& session, const std::vector<RegionEquations>& regions);

// Kernels of a channel: of all its dots, and what they might as well be.
struct ChannelKernels {
  ExponentialMixture all, stiff, more_blurred;
  std::vector<ExponentialMixture> without_group;  // of dots, one after the other
};

// Kernels of a channel and what their tails say.
struct ChannelTails {
  ChannelKernels kernels;
  DeepProfile all, more_blurred;
  std::vector<DeepProfile> without_group;
};

// With deviations from how far dots differ, from a blur that is not exactly known, from smoothness,
// and from what no tail tells.
ChannelTails fit_tails(const std::vector<const KernelEquations*>& dots, const SkinPrior& prior,
                       const PatternBlur& blur);

// `tails`: of one channel, one a region.
void lean_on_each_other(const std::vector<ChannelTails*>& tails);

// Adds what other dots and another blur would make of the layers to their deviations.
void widen_layers(const ChannelTails& tails, const KnownSkin& known, LayeredProfile* layers);

// Both layers against one dipole, the tail's l_d being `ld_mm`.
LayerContest contest_of(const std::vector<const KernelEquations*>& dots, double ld_mm,
                        double shallow_share, const PatternBlur& blur);

}  // namespace lamella::fit
