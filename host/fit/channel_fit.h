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
  double expected_mm = 0;  // by their pixels
  cv::Mat1d agreed,
      doubted;  // blurred exponentials: by what all kernels agree on, by one sigma more
};

PatternBlur pattern_blur(const Session& session, const std::vector<RegionEquations>& regions);

// What is known of a channel before its kernel is looked at.
struct KnownSkin {
  SkinPrior prior;
  ShallowLight shallow;
  double thickness_mm;
};

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

struct ChannelFit {
  DeepProfile deep;
  LayeredProfile layers;
  LayerContest contest;
};

ChannelFit fit_channel(const std::vector<const KernelEquations*>& dots, const ChannelTails& tails,
                       const KnownSkin& known, const PatternBlur& blur);

}  // namespace lamella::fit
