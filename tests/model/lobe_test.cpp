#include "model/lobe.h"

#include <gtest/gtest.h>

#include "model/torrance_sparrow.h"
#include "model/transmittance.h"

namespace lamella::model {
namespace {

std::vector<double> theta_table(int steps = 90) {
  std::vector<double> theta;
  for (int i = 0; i <= steps; ++i) theta.push_back(double(kPi) / 4 * i / steps);
  return theta;
}

std::vector<double> gaussian(const std::vector<double>& theta, double m) {
  std::vector<double> p;
  for (double t : theta) p.push_back(7.0 * std::exp(-t * t / (m * m)));
  return p;
}

double hemisphere_integral(const LobeTable& lobe) {
  double sum = 0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double theta = (i + 0.5) / kSteps * double(kPi) / 2;
    sum += 2 * double(kPi) * double(lobe.density(float(std::cos(theta)))) * std::cos(theta) *
           std::sin(theta) * double(kPi) / 2 / kSteps;
  }
  return sum;
}

TEST(LobeTable, IntegratesToOneWithItsTailWhateverTheScaleOfItsData) {
  for (double m : {0.1, 0.2, 0.35, 0.5}) {
    EXPECT_NEAR(hemisphere_integral(LobeTable(theta_table(), gaussian(theta_table(), m))), 1.0,
                2e-3);
  }
}

TEST(LobeTable, ContinuesAGaussianBeyondItsEnd) {
  const double m = 0.5;
  const LobeTable lobe(theta_table(), gaussian(theta_table(), m));
  const float at_60 = lobe.density(std::cos(kPi / 3)), at_30 = lobe.density(std::cos(kPi / 6));
  const double expected = std::exp(-(1 / 9.0 - 1 / 36.0) * double(kPi * kPi) / (m * m));
  EXPECT_NEAR(at_60 / at_30, expected, 0.03 * expected);
}

TEST(Beckmann, IsNormalisedAsTheLobeIs) {
  for (double m : {0.08, 0.3, 0.6}) {
    double sum = 0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const double mu = (i + 0.5) / kSteps;
      sum += 2 * double(kPi) * beckmann(mu, m) * mu / kSteps;
    }
    EXPECT_NEAR(sum, 1.0, 1e-4);
  }
}

TEST(GaussianWidth, RecoversTheWidthOfAGaussianTable) {
  for (double m : {0.15, 0.3, 0.45}) {
    EXPECT_NEAR(gaussian_width(theta_table(), gaussian(theta_table(), m)), m, 1e-5);
  }
}

TEST(VGroove, ShadowsNothingInExactBackscatterUpTo45Degrees) {
  for (double degrees : {0.0, 20.0, 40.0, 44.9}) {
    const double c = std::cos(degrees * double(kPi) / 180);
    EXPECT_DOUBLE_EQ(v_groove(c, c, c, 1.0), 1.0);
  }
  const double c50 = std::cos(50 * double(kPi) / 180);
  EXPECT_LT(v_groove(c50, c50, c50, 1.0), 1.0);
}

TEST(TorranceSparrow, IsReciprocal) {
  const LobeTable lobe(theta_table(), gaussian(theta_table(), 0.3));
  const Vec3 n(0, 0, 1);
  for (const Vec3& l : {Vec3(0.1f, 0.2f, 0.9f), Vec3(-0.6f, 0.3f, 0.4f), Vec3(0.8f, 0, 0.3f)}) {
    const Vec3 a = unit(l), b = unit(Vec3(0.3f, -0.1f, 0.8f));
    EXPECT_NEAR(torrance_sparrow(lobe, n, a, b), torrance_sparrow(lobe, n, b, a), 1e-6f);
  }
}

TEST(TorranceSparrow, InExactBackscatterIsTheDistributionOverTheCosineSquared) {
  const LobeTable lobe(theta_table(), gaussian(theta_table(), 0.3));
  const Vec3 n(0, 0, 1), w = unit(Vec3(0.4f, 0, 0.9f));
  const float expected = lobe.density(w[2]) * float(fresnel_at_normal()) / (w[2] * w[2]);
  EXPECT_NEAR(torrance_sparrow(lobe, n, w, w), expected, 1e-4f * expected);
}

TEST(TorranceSparrow, ReflectsNoMoreThanItReceivesWithTheQuarterOfACleanInterface) {
  for (double m : {0.1, 0.2, 0.35, 0.5}) {
    const LobeTable lobe(theta_table(), gaussian(theta_table(), m));
    for (double mu : {0.05, 0.2, 0.5, 1.0}) {
      EXPECT_LT(0.25 * directional_reflectance(lobe, mu), 1.0) << m << " " << mu;
    }
  }
}

TEST(TorranceSparrow, DirectionalReflectanceAgreesWithTheIntegralOverLights) {
  const LobeTable lobe(theta_table(), gaussian(theta_table(), 0.3));
  const Vec3 n(0, 0, 1), v(std::sqrt(1 - 0.36f), 0, 0.6f);
  double sum = 0;
  constexpr int kPolar = 300, kAzimuth = 600;
  for (int i = 0; i < kPolar; ++i) {
    const float mu = (float(i) + 0.5f) / kPolar, s = std::sqrt(1 - mu * mu);
    for (int k = 0; k < kAzimuth; ++k) {
      const float azimuth = 2 * kPi * float(k) / kAzimuth;
      const Vec3 l(s * std::cos(azimuth), s * std::sin(azimuth), mu);
      sum += double(torrance_sparrow(lobe, n, l, v) * mu);
    }
  }
  sum *= 2 * double(kPi) / (kPolar * kAzimuth);
  EXPECT_NEAR(directional_reflectance(lobe, 0.6), sum, 0.01 * sum);
}

TEST(TorranceSparrow, OfANearlySmoothCleanInterfaceReflectsAsFresnelSays) {
  const LobeTable lobe(theta_table(2000), gaussian(theta_table(2000), 0.06));
  for (double mu : {0.5, 0.8, 1.0}) {
    const double smooth = fresnel_reflectance(mu);
    EXPECT_NEAR(0.25 * directional_reflectance(lobe, mu), smooth, 0.04 * smooth) << mu;
  }
}

TEST(Transmittance, OfACleanRoughSurfaceIsNearTheSmoothOneAndFallsTowardsGrazing) {
  const TransmittanceTable smooth;
  const TransmittanceTable rough(LobeTable(theta_table(), gaussian(theta_table(), 0.2)), 0.25);
  EXPECT_NEAR(rough(1.f), smooth(1.f), 0.002f);
  EXPECT_NEAR(rough(0.6f), smooth(0.6f), 0.02f);
  EXPECT_LT(rough(0.2f), rough(0.6f));
}

}  // namespace
}  // namespace lamella::model
