#include "fit/channel_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "fit/jackknife.h"
#include "fit/layered_kernel.h"
#include "fit/region_lean.h"

namespace lamella::fit {

namespace {

constexpr int kJackknifeGroups = 8;
// Of how far ten times the smoothness moves l_d: what the smoothness itself is taken to do to it.
constexpr double kSmoothShare = 1.0 / 3;
constexpr double kLeastOfKernel = 0.2;  // of all dots': another draw's is light too, not less
constexpr double kBlurDoubt = 0.15;     // one sigma, relative, of what the kernels agree on

ChannelKernels channel_kernels(const std::vector<const KernelEquations*>& dots,
                               const PatternBlur& blur) {
  const auto solve = [&](const KernelEquations& equations, double smoothness) {
    return solve_mixture(equations, kOffsetSigma, blur.agreed, smoothness);
  };
  const KernelEquations all = sum_of(dots);
  ChannelKernels kernels{solve(all, kTailSmoothness),
                         solve(all, kStiffSmoothness),
                         solve_mixture(all, kOffsetSigma, blur.doubted, kTailSmoothness),
                         {}};
  const int groups = std::min(kJackknifeGroups, int(dots.size()));
  for (int g = 0; groups > 1 && g < groups; ++g) {
    KernelEquations rest = all;
    for (size_t i = size_t(g); i < dots.size(); i += size_t(groups)) rest += dots[i]->scaled(-1);
    kernels.without_group.push_back(solve(rest, kTailSmoothness));
  }
  return kernels;
}

// What as many other dots might have said.
struct AnotherDraw {
  ExponentialMixture kernel;
  DeepProfile deep;
};

// One for each group that was left out: off by as much as dots differ, of which leaving it out
// shows but a part. The figures of a slab lie along a valley that bends on that way, so that no
// multiple of what they do in its first part is what they do in the whole.
std::vector<AnotherDraw> other_draws(const ChannelTails& tails) {
  const std::vector<ExponentialMixture>& without = tails.kernels.without_group;
  const double count = double(without.size()), whole = std::sqrt(count - 1);
  std::array<double, ExponentialMixture::kSize> mean{};
  double mean_log_ld = 0;
  for (size_t g = 0; g < without.size(); ++g) {
    for (size_t k = 0; k < mean.size(); ++k) mean[k] += without[g].weight[k] / count;
    mean_log_ld += std::log(tails.without_group[g].ld_mm) / count;
  }
  std::vector<AnotherDraw> draws(without.size(), {tails.kernels.all, tails.all});
  for (size_t g = 0; g < without.size(); ++g) {
    for (size_t k = 0; k < mean.size(); ++k) {
      draws[g].kernel.weight[k] += whole * (without[g].weight[k] - mean[k]);
    }
    draws[g].deep.ld_mm *= std::exp(whole * (std::log(tails.without_group[g].ld_mm) - mean_log_ld));
  }
  return draws;
}

// Of others, from `profile`.
LayeredProfile root_mean_square_off(const std::vector<LayeredProfile>& others,
                                    const LayeredProfile& profile) {
  LayeredProfile off;
  const auto add = [&](double to, double from, double* rms) {
    *rms = std::hypot(*rms, (to - from) / std::sqrt(double(others.size())));
  };
  for (const LayeredProfile& other : others) {
    add(other.alpha_dot, profile.alpha_dot, &off.alpha_dot);
    add(other.shallow_alpha, profile.shallow_alpha, &off.shallow_alpha);
    add(other.shallow_ld_mm, profile.shallow_ld_mm, &off.shallow_ld_mm);
  }
  return off;
}

}  // namespace

PatternBlur pattern_blur(const Session& session, const std::vector<RegionEquations>& regions) {
  std::vector<KernelEquations> kernels;
  for (const RegionEquations& region : regions) {
    for (const auto& dots : region) {
      if (!dots.empty()) kernels.push_back(sum_of(dots));
    }
  }
  const double expected_mm = footprint_mm(session.left, session.projector);
  const double blur_mm = shared_blur_mm(kernels, kOffsetSigma, expected_mm);
  return {blur_mm, blurred_exponentials(blur_mm), blurred_exponentials((1 + kBlurDoubt) * blur_mm)};
}

ChannelTails fit_tails(const std::vector<const KernelEquations*>& dots, const SkinPrior& prior,
                       const PatternBlur& blur) {
  ChannelTails tails{channel_kernels(dots, blur), {}, {}, {}};
  tails.all = fit_deep_profile(tails.kernels.all, prior);
  tails.more_blurred = fit_deep_profile(tails.kernels.more_blurred, prior);
  std::vector<double> ld_mm;
  for (const ExponentialMixture& kernel : tails.kernels.without_group) {
    tails.without_group.push_back(fit_deep_profile(kernel, prior));
    ld_mm.push_back(tails.without_group.back().ld_mm);
  }
  DeepProfile* tail = &tails.all;
  const double smoothed_mm = fit_deep_profile(tails.kernels.stiff, prior).ld_mm - tail->ld_mm;
  const double of_dots_mm = std::hypot(tail->ld_mm_stddev, jackknife_stddev(ld_mm));
  tail->ld_mm_stddev = std::hypot(std::hypot(of_dots_mm, tails.more_blurred.ld_mm - tail->ld_mm),
                                  kSmoothShare * smoothed_mm);
  return tails;
}

void lean_on_each_other(const std::vector<ChannelTails*>& tails) {
  std::vector<DeepProfile> own;
  for (const ChannelTails* t : tails) own.push_back(t->all);
  const std::vector<DeepProfile> leaned = leaned_on_each_other(own);
  for (size_t i = 0; i < tails.size(); ++i) {
    const double factor = leaned[i].ld_mm / own[i].ld_mm;
    tails[i]->all = leaned[i];
    tails[i]->more_blurred.ld_mm *= factor;
    for (DeepProfile& deep : tails[i]->without_group) deep.ld_mm *= factor;
  }
}

void widen_layers(const ChannelTails& tails, const KnownSkin& known, LayeredProfile* layers) {
  const auto refine = [&](const ExponentialMixture& kernel, const DeepProfile& deep) {
    const auto value = [&](double r_mm) {
      return std::max(kernel(r_mm), kLeastOfKernel * tails.kernels.all(r_mm));
    };
    return refine_layered_profile(value, deep, known, *layers);
  };
  std::vector<LayeredProfile> drawn;
  for (const AnotherDraw& draw : other_draws(tails)) {
    drawn.push_back(refine(draw.kernel, draw.deep));
  }
  widen(root_mean_square_off(drawn, *layers), layers);
  widen(root_mean_square_off({refine(tails.kernels.more_blurred, tails.more_blurred)}, *layers),
        layers);
}

LayerContest contest_of(const std::vector<const KernelEquations*>& dots, double ld_mm,
                        double shallow_share, const PatternBlur& blur) {
  LayeredKernel given;
  given.deep_ld_mm = ld_mm;
  given.shallow_share = shallow_share;
  given.thickness_mm = kSlabs_mm[0];
  const LayeredKernel both =
      fit_layered_kernel(WeightEquations(sum_of(dots), kOffsetSigma), given, blur.agreed_mm);
  return contest_layers(dots, both, kOffsetSigma, blur.agreed_mm);
}

}  // namespace lamella::fit
