#include "fit/exponential_mixture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "fit/kernel_waves.h"
#include "fit/layer_profile.h"
#include "fit/layered_kernel.h"

namespace lamella::fit {
namespace {

constexpr double kMixtureBlur_mm = 0.2;

// Dermis under a slab.
LayeredKernel mixture_truth() {
  LayeredKernel kernel;
  kernel.deep_s = 0.3;
  kernel.deep_ld_mm = 1.4;
  kernel.shallow_s = 0.5;
  kernel.shallow_ld_mm = 0.6;
  kernel.shallow_share = 0.4;
  kernel.thickness_mm = 0.5;
  return kernel;
}

// What waves show of it through pixels that blur.
KernelEquations seen_waves(const RadialProfile& kernel, int count, double step) {
  KernelEquations equations;
  for (int i = 0; i < count; ++i) {
    const double f = step * i, blur = std::exp(-2 * std::pow(M_PI * kMixtureBlur_mm * f, 2));
    KernelEquations::Vector row = KernelEquations::Vector::Zero();
    for (int j = 0; j < GaussianBasis::kSize; ++j) row(j) = GaussianBasis::transfer(j, f);
    row(GaussianBasis::kSize) = 1;
    equations.add(row, testing::wave_share(kernel, f) * blur, 1e4);
  }
  return equations;
}

ExponentialMixture found_in(const KernelEquations& waves) {
  return solve_mixture(waves, 1e-4, blurred_exponentials(kMixtureBlur_mm), kTailSmoothness);
}

// Relative, by area, from 0.1 to 8 mm.
double area_between(const RadialProfile& found, const RadialProfile& truth) {
  double apart = 0, light = 0;
  for (double r = 0.1; r < 8; r *= 1.02) {
    apart += r * r * std::abs(found(r) - truth(r));
    light += r * r * truth(r);
  }
  return apart / light;
}

ExponentialMixture one_of(int k) {
  ExponentialMixture one;
  one.weight[size_t(k)] = 1;
  return one;
}

TEST(ExponentialMixture, IntegratesToOneOverThePlane) {
  EXPECT_NEAR(testing::wave_share(one_of(18), 0), 1, 1e-3);
}

TEST(ExponentialMixture, IsBlurredAsWavesAreByAGaussian) {
  const cv::Mat1d blurred = blurred_exponentials(kMixtureBlur_mm);
  for (int k : {5, 18, 28}) {
    for (double f : {0.0, 0.05, 0.2, 0.6, 1.0}) {
      double seen = 0;
      for (int j = 0; j < GaussianBasis::kSize; ++j) {
        seen += blurred(j, k) * GaussianBasis::transfer(j, f);
      }
      const double blur = std::exp(-2 * std::pow(M_PI * kMixtureBlur_mm * f, 2));
      EXPECT_NEAR(seen, testing::wave_share(one_of(k), f) * blur, 0.01) << k << " at " << f;
    }
  }
}

TEST(ExponentialMixture, FindsALayeredKernelInWhatItShowsThroughTheBlur) {
  const ExponentialMixture found = found_in(seen_waves(mixture_truth(), 60, 0.03));
  EXPECT_LT(area_between(found, mixture_truth()), 0.04);
}

// Least squares over what is not negative picks a few lengths, others with every noise.
TEST(ExponentialMixture, IsOfManyLengthsAndNotOfAFewThatNoisePicks) {
  const ExponentialMixture found = found_in(seen_waves(mixture_truth(), 60, 0.03));
  const auto used = std::count_if(found.weight.begin(), found.weight.end(),
                                  [](double weight) { return weight > 1e-4; });
  EXPECT_GT(used, 9);
}

// Where nothing was measured it goes on as it went: a ratio to the truth that rises and falls is a
// ripple, and a tail's slope is read off it.
TEST(ExponentialMixture, DoesNotRippleWhereLittleWasMeasured) {
  const ExponentialMixture found = found_in(seen_waves(mixture_truth(), 8, 0.0625));
  for (double r = 0.6; r < 6; r *= 1.1) {
    EXPECT_NEAR(found(r) / mixture_truth()(r), 1, 0.12) << "at " << r << " mm";
  }
}

TEST(SharedBlur, IsFoundInWhatKernelsOfManyLengthsShow) {
  std::vector<KernelEquations> kernels;
  for (double ld_mm : {0.5, 1.0, 2.0}) {
    LayeredKernel kernel = mixture_truth();
    kernel.deep_ld_mm = ld_mm;
    kernels.push_back(seen_waves(kernel, 60, 0.03));
  }
  for (double expected_mm : {0.15, 0.2, 0.26}) {
    EXPECT_NEAR(shared_blur_mm(kernels, 1e-4, expected_mm), kMixtureBlur_mm, 0.03) << expected_mm;
  }
}

TEST(SharedBlur, IsWhatPixelsLetOneExpectWhereNothingIsSeen) {
  EXPECT_NEAR(shared_blur_mm({}, 1e-4, 0.17), 0.17, 1e-6);
}

RadialProfile share_of_dipole(double s, double ld_mm) {
  const model::Dipole<double> skin{model::alpha_from_s(s), ld_mm};
  return [=](double r) {
    return model::dipole_reflectance(skin, r) / model::diffuse_reflectance_at_s(s);
  };
}

// The l_d of the dipole that is nearest to `reflectance` of it from 1 to 8 mm, amplitude and all.
double nearest_dipole_mm(const RadialProfile& kernel, double reflectance) {
  double least = std::numeric_limits<double>::infinity(), nearest_mm = 0;
  for (double s = 0.1; s < 1.7; s += 0.02) {
    for (double ld_mm = 0.7; ld_mm < 2; ld_mm *= 1.01) {
      const model::Dipole<double> skin{model::alpha_from_s(s), ld_mm};
      double cost = 0;
      for (double r = 1; r < 8; r *= 1.1) {
        const double light = r * r * kernel(r);
        cost +=
            light *
            std::pow(std::log(model::dipole_reflectance(skin, r) / (reflectance * kernel(r))), 2);
      }
      if (cost < least) nearest_mm = ld_mm;
      least = std::min(least, cost);
    }
  }
  return nearest_mm;
}

// Much melanin over it lets a twentieth of dermis's light through: the shape is dermis's, the
// nearest dipole is not.
TEST(DeepProfile, UnderMuchMelaninIsToldByTheReflectance) {
  const RadialProfile kernel = share_of_dipole(0.27, 1.4);
  const double reflectance = 0.05 * model::diffuse_reflectance_at_s(0.27);
  const double truth_mm = nearest_dipole_mm(kernel, reflectance);
  EXPECT_GT(fit_deep_profile(kernel, {0.38, 0}).ld_mm / truth_mm, 1.15);
  EXPECT_NEAR(fit_deep_profile(kernel, {0.38, reflectance}).ld_mm / truth_mm, 1, 0.08);
}

// A texture may be far from 1 over a whole region: l_d must not go with it.
TEST(DeepProfile, OfDermisHardlyGoesWithTheTexture) {
  const double ld_mm = 1.4, s = 0.38 / ld_mm;
  for (double texture : {0.75, 1.0, 1.33}) {
    const SkinPrior prior{0.38, texture * model::diffuse_reflectance_at_s(s)};
    EXPECT_NEAR(fit_deep_profile(share_of_dipole(s, ld_mm), prior).ld_mm / ld_mm, 1, 0.06)
        << texture;
  }
}

}  // namespace
}  // namespace lamella::fit
