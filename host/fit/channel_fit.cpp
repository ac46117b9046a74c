#include "fit/channel_fit.h"

#include <algorithm>

#include "fit/jackknife.h"
#include "fit/layered_kernel.h"
#include "fit/region_lean.h"

namespace lamella::fit {

namespace {

constexpr int kJackknifeGroups = 8;
// Of how far ten times the smoothness moves l_d: what the smoothness itself is taken to do to it.
constexpr double kSmoothShare = 1.0 / 3;
constexpr double kBlurDoubt = 0.15;  // one sigma, relative, of what the kernels agree on

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

void widen_layers(const ChannelTails& tails, const ShallowLight& shallow, LayeredProfile* layers) {
  const auto refine = [&](const ExponentialMixture& kernel, const DeepProfile& deep) {
    return refine_layered_profile(kernel, deep, shallow, *layers);
  };
  std::vector<double> alpha_dot, shallow_alpha, shallow_ld_mm;
  for (size_t g = 0; g < tails.without_group.size(); ++g) {
    const LayeredProfile rest = refine(tails.kernels.without_group[g], tails.without_group[g]);
    alpha_dot.push_back(rest.alpha_dot);
    shallow_alpha.push_back(rest.shallow_alpha);
    shallow_ld_mm.push_back(rest.shallow_ld_mm);
  }
  LayeredProfile of_dots;
  of_dots.alpha_dot = jackknife_stddev(alpha_dot);
  of_dots.shallow_alpha = jackknife_stddev(shallow_alpha);
  of_dots.shallow_ld_mm = jackknife_stddev(shallow_ld_mm);
  const LayeredProfile blurred = refine(tails.kernels.more_blurred, tails.more_blurred);
  LayeredProfile of_blur;
  of_blur.alpha_dot = blurred.alpha_dot - layers->alpha_dot;
  of_blur.shallow_alpha = blurred.shallow_alpha - layers->shallow_alpha;
  of_blur.shallow_ld_mm = blurred.shallow_ld_mm - layers->shallow_ld_mm;
  widen(of_dots, layers);
  widen(of_blur, layers);
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
