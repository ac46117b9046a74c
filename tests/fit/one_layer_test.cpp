// One homogeneous layer, or a layer on top of another.
#include "fit/one_layer.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "model/half_space.h"

namespace lamella::fit {
namespace {

constexpr double kBlurOfTest_mm = 0.2;
constexpr std::array<double, 3> kScattering_per_mm{1.9, 2.5, 3.1}, kReflectance{0.5, 0.32, 0.28};

// Share of a wave that a kernel leaves, by cycles per mm.
using Transfer = std::function<double(double)>;

Transfer homogeneous(double reflectance, double scattering_per_mm) {
  const model::HalfSpaceTransfer transfer(model::log_absorption_of(reflectance));
  return [=](double f) { return transfer(std::log(f / scattering_per_mm)); };
}

// What dots say of a kernel: waves as their lattice has them.
KernelEquations dot_of(const Transfer& kernel, double noise, std::mt19937* random) {
  std::normal_distribution<double> normal;
  KernelEquations equations;
  for (int i = 1; i < 12; ++i) {
    constexpr double amplitude = 1;
    const double f = i / 16.0;
    const double x = M_PI * kBlurOfTest_mm * f;
    KernelEquations::Vector row = KernelEquations::Vector::Zero();
    for (int j = 0; j < GaussianBasis::kSize; ++j) {
      row(j) = amplitude * GaussianBasis::transfer(j, f);
    }
    row(GaussianBasis::kSize) = 1;
    const double value = amplitude * kernel(f) * std::exp(-2 * x * x);
    equations.add(row, value + noise * normal(*random), 1, 100);
  }
  return equations;
}

struct Skin {
  std::vector<KernelEquations> dots;  // of each channel the same number
  OneLayerRegion region;
};

// `darker`: what a layer on top leaves of the light, spread as it was.
Skin skin_of(double darker, double noise) {
  constexpr size_t kDots = 12;
  Skin skin;
  std::mt19937 random(5);
  for (size_t i = 0; i < 3 * kDots; ++i) {
    const size_t c = i / kDots;
    skin.dots.push_back(
        dot_of(homogeneous(kReflectance[c], kScattering_per_mm[c]), noise, &random));
  }
  for (size_t c = 0; c < 3; ++c) {
    skin.region.reflectance[c] = darker * kReflectance[c];
    for (size_t i = 0; i < kDots; ++i) {
      skin.region.dots[c].push_back(&skin.dots[c * kDots + i]);
    }
  }
  return skin;
}

OneLayerVerdict verdict_on(const Skin& skin) {
  return judge_one_layer(std::vector<OneLayerRegion>(6, skin.region), kBlurOfTest_mm);
}

TEST(OneLayer, IsFoundWhereTheKernelsAreThoseOfWhatIsReflected) {
  const OneLayerVerdict verdict = verdict_on(skin_of(1, 1e-5));
  EXPECT_TRUE(verdict.is_one) << verdict.why;
  EXPECT_NEAR(verdict.excess, 0, 0.02);
  EXPECT_NEAR(verdict.log_blur, 0, 0.05);
  EXPECT_NE(verdict.why.find("one is enough: "), std::string::npos) << verdict.why;
}

TEST(OneLayer, IsNotWhereALayerOnTopTakesSomeOfTheLight) {
  const OneLayerVerdict verdict = verdict_on(skin_of(0.85, 1e-5));
  EXPECT_FALSE(verdict.is_one) << verdict.why;
  EXPECT_NEAR(verdict.excess, -std::log(0.85), 0.04);
  EXPECT_NE(verdict.why.find("more than one, as "), std::string::npos) << verdict.why;
}

TEST(OneLayer, IsNotWhereSkinReflectsMoreThanItsKernelsLet) {
  const OneLayerVerdict verdict = verdict_on(skin_of(1.3, 1e-5));
  EXPECT_FALSE(verdict.is_one) << verdict.why;
  EXPECT_NE(verdict.why.find("% less than is measured"), std::string::npos) << verdict.why;
}

TEST(OneLayer, IsNotClaimedWhereNoiseHidesASecondOne) {
  const OneLayerVerdict verdict = verdict_on(skin_of(1, 0.02));
  EXPECT_FALSE(verdict.is_one) << verdict.why;
  EXPECT_GT(verdict.excess_stddev, 0.05);
  EXPECT_NE(verdict.why.find("one or two, which is not told apart: "), std::string::npos)
      << verdict.why;
}

TEST(OneLayer, IsNotClaimedWhereTheDotsTellNothingOfIt) {
  Skin skin = skin_of(1, 1e-5);
  for (KernelEquations& dot : skin.dots) dot = dot.scaled(1e-4), dot.left(14, 14) = 1e4;
  const OneLayerVerdict verdict = verdict_on(skin);
  EXPECT_FALSE(verdict.is_one) << verdict.why;
  EXPECT_EQ(verdict.why,
            "not known, as the dots hardly tell what one homogeneous layer would reflect");
}

TEST(OneLayer, IsNotJudgedWithoutDotsOrWithoutLight) {
  EXPECT_FALSE(judge_one_layer({}, kBlurOfTest_mm).is_one);
  EXPECT_EQ(judge_one_layer({}, kBlurOfTest_mm).why, "");
  Skin skin = skin_of(1, 0);
  skin.region.reflectance = {0, 0, 0};
  EXPECT_EQ(verdict_on(skin).why, "");
}

TEST(OneLayer, WeightsLetWavesThroughAsTheBlurredKernelDoes) {
  const WeightEquations::Vector weights = half_space_weights(-2, 2.5, kBlurOfTest_mm);
  EXPECT_NEAR(weights.sum(), 1, 1e-12);
  const model::HalfSpaceTransfer transfer(-2);
  for (double f : {0.05, 0.1, 0.25, 0.4, 0.8, 1.2}) {
    double left = 0;
    for (int j = 0; j < GaussianBasis::kSize; ++j)
      left += weights(j) * GaussianBasis::transfer(j, f);
    const double x = M_PI * kBlurOfTest_mm * f;
    EXPECT_NEAR(left, transfer(std::log(f / 2.5)) * std::exp(-2 * x * x), 0.003) << f;
  }
}

}  // namespace
}  // namespace lamella::fit
