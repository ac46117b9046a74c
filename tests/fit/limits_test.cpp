// What a fit of a region or a pixel says where there is next to nothing to fit. Each case names
// what fails where it is not seen to. Others stand beside what they are limits of: no dot and one
// dot in dots_test.cpp and layer_choice_test.cpp, a lobe that is next to nothing in
// intensity_test.cpp, noise alone and specks in specular_test.cpp; whole bursts (not a number,
// infinity, exposure, channels that change places, a rig that is turned, a face mirrored, a region
// of one pixel) in end_to_end/hard_cases_test.cpp and spoilt_burst_test.cpp.
#include <gtest/gtest.h>

#include <numeric>

#include "fit/exponential_mixture.h"
#include "fit/gradient_inversion.h"
#include "fit/layer_profile.h"
#include "fit/layered_kernel.h"
#include "fit/led_response.h"
#include "fit/lobe_fit.h"
#include "fit/non_negative.h"
#include "fit/phase_asymmetry.h"
#include "synthetic_sphere.h"

namespace lamella::fit {
namespace {

double sum_of(const GaussianBasis::Weights& weights) {
  return std::accumulate(weights.begin(), weights.end(), 0.0);
}

// Failure: weights are divided by their sum.
TEST(FitLimits, AKernelOfNoSamplesIsTheOneThatItIsPulledTo) {
  const Kernel kernel = solve_kernel(KernelEquations(), kOffsetSigma, 3);
  for (const double w : kernel.weight) EXPECT_GE(w, 0);
  EXPECT_NEAR(sum_of(kernel.weight), 1, 1e-9);
  EXPECT_TRUE(std::isfinite(kernel.offset));
}

// Failure: as above, of which nothing but smoothness is left.
TEST(FitLimits, AMixtureOfNoSamplesIsOneAllTheSame) {
  const ExponentialMixture kernel =
      solve_mixture(KernelEquations(), kOffsetSigma, blurred_exponentials(0.2), kTailSmoothness);
  double sum = 0;
  for (const double w : kernel.weight) {
    EXPECT_GE(w, 0);
    sum += w;
  }
  EXPECT_NEAR(sum, 1, 1e-9);
}

// Failure: the slope of a tail that is not there, given as a length that is believed.
TEST(FitLimits, LightThatDoesNotTravelHasNoTailAndItsLengthIsSaidToBeABound) {
  GaussianBasis::Weights narrow{};
  narrow[0] = 1;
  const DeepProfile deep =
      fit_deep_profile([&](double r_mm) { return GaussianBasis::profile(narrow, r_mm); }, {});
  EXPECT_NE(deep.at_bound, "");
  EXPECT_TRUE(std::isfinite(deep.ld_mm_stddev));
  EXPECT_GT(deep.ld_mm_stddev, deep.ld_mm);
}

// Failure: a multipole that reflects less than nothing, divided by its total; or a layer that is
// there and is dropped, as the kernel alone would have it thinner than diffusion allows.
TEST(FitLimits, ASlabThatTheKernelWouldMakeTooThinForDiffusionReflectsWhatTheStripesMeasured) {
  const GaussianBasis::Weights weights = exponential_kernel(1.5);
  const auto kernel = [&](double r_mm) { return GaussianBasis::profile(weights, r_mm); };
  for (double albedo : {0.03, 0.15, 0.4}) {
    const DeepProfile deep = fit_deep_profile(kernel, {});
    for (const LayeredProfile& layers : fit_layered_profiles(kernel, deep, {{}, {0.3, albedo}})) {
      EXPECT_TRUE(layers.shallow_fitted) << layers.shallow_why;
      const model::Multipole<double> slab{layers.shallow_alpha, layers.shallow_ld_mm,
                                          layers.thickness_mm};
      EXPECT_GT(model::multipole_total(slab), albedo / 20);
      EXPECT_LT(model::multipole_total(slab), albedo * 3);
      EXPECT_TRUE(std::isfinite(layers.alpha_dot));
    }
  }
}

// Failure: 0/0 of a pixel without light, and a normal without length.
TEST(FitLimits, APixelWithoutLightHasANormalOfLengthOne) {
  const LedsFrom leds(even_stage(), {0, 0, 0});
  for (const Vec3& guess : {Vec3(0, 0, 1), Vec3(0, 0, 0)}) {
    const Vec3 n = invert_mean_direction(leds, 1, {0, 0, 0}, guess);
    EXPECT_TRUE(is_finite(n));
    EXPECT_LE(length(n), 1.001f);
  }
  const LedsFrom dark(LightStage({{{0, 0, 1}, 0, {0, 0, 0}}}), {0, 0, 0});
  EXPECT_TRUE(is_finite(lambertian_mean_direction(dark, 1, Vec3(0, 0, 1))));
}

// Failure: a mean direction longer than any surface gives, out of noise.
TEST(FitLimits, AMeanDirectionThatNoSurfaceHasGivesTheNormalNextToIt) {
  const Vec3 n = unit(Vec3(0.3f, 0.2f, 1));
  EXPECT_GT(dot(invert_mean_direction(LedsFrom(even_stage(), {0, 0, 0}), 1, n * 5.f, n), n), 0.99f);
}

LedResponse response_of(const Vec3& n, const Vec3& v, float g, float reached) {
  LedCell cell;
  for (auto* values : {&cell.x, &cell.y, &cell.radiance, &cell.l_v, &cell.reached}) {
    values->assign(LedCell::kLanes, 0.f);
  }
  cell.z.assign(LedCell::kLanes, 1.f);
  cell.per_v_h.assign(LedCell::kLanes, 1.4f);
  cell.fresnel.assign(LedCell::kLanes, 0.03f);
  cell.radiance[0] = 1;
  cell.reached[0] = reached;
  cell.used = LedCell::kLanes;
  return led_response(cell, {gaussian_lobe(0.3), model::TransmittanceTable(), g}, n, v);
}

// Failure: 1/(n.v), the share of no light, and 1 - g^2 beside 1 + g^2 - 2 g cos.
TEST(FitLimits, TheResponseToTheLedsIsANumberHoweverGrazingDarkOrForward) {
  const Vec3 n(0, 0, 1);
  const LedResponse below = response_of(n, unit(Vec3(1, 0, -0.5f)), 0.65f, 1);
  EXPECT_EQ(below.lobe, 0);
  EXPECT_EQ(below.single, 0);
  for (const float height : {0.021f, 0.1f, 1.f}) {
    for (const float g : {0.f, 0.65f, 0.99f}) {
      for (const float reached : {0.f, 1.f}) {
        const LedResponse r = response_of(n, unit(Vec3(1, 0, height)), g, reached);
        EXPECT_TRUE(std::isfinite(r.lobe) && r.lobe >= 0) << height << " " << g;
        EXPECT_TRUE(std::isfinite(r.single) && r.single >= 0) << height << " " << g;
        EXPECT_EQ(r.share, reached) << height << " " << g;
      }
    }
  }
}

// Failure: unknowns that no equation speaks of.
TEST(FitLimits, EquationsOfNothingLeaveTheUnknownsAtNothing) {
  const cv::Mat1d x = solve_non_negative(cv::Mat1d::zeros(3, 3), cv::Mat1d::zeros(3, 1), 3);
  for (const double value : x) EXPECT_EQ(value, 0);
}

// Failure: medians and means of no sample.
TEST(FitLimits, ARegionWithoutASampleHasATypicalLobeAndIsNotJudged) {
  const std::vector<RegionFit> fits = fit_lobes({}, {prior_region_fit()}, 4);
  EXPECT_FALSE(fits[0].lobe.fitted);
  EXPECT_EQ(fits[0].lobe.doubt, Doubt::kNotJudged);
  EXPECT_EQ(fits[0].lobe.p, prior_region_fit().lobe.p);
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(fits[0].single.amplitude[c], 0);
    EXPECT_TRUE(std::isfinite(fits[0].single.amplitude_stddev[c]));
  }
}

// Failure: eq. 8 is steep without end in alpha' at 1.
TEST(FitLimits, SkinThatReflectsNothingOrEverythingHasAReducedAlbedo) {
  EXPECT_NEAR(reduced_albedo_of(0), 0, 1e-9);
  EXPECT_NEAR(reduced_albedo_of(1), 1, 1e-9);
  EXPECT_NEAR(reduced_albedo_of(1.5), 1, 1e-9);
}

}  // namespace
}  // namespace lamella::fit
