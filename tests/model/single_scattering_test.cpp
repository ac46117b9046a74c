#include "model/single_scattering.h"

#include <gtest/gtest.h>

namespace lamella::model {
namespace {

struct Moments {
  double total = 0, mean_cosine = 0;
};

Moments moments(double g) {
  Moments m;
  constexpr int kSteps = 200000;
  for (int i = 0; i < kSteps; ++i) {
    const double mu = -1 + 2 * (i + 0.5) / kSteps;
    const double share = henyey_greenstein(mu, g) * 4 * double(kPi) / kSteps;
    m.total += share;
    m.mean_cosine += mu * share;
  }
  return m;
}

TEST(HenyeyGreenstein, IntegratesToOneAndHasMeanCosineG) {
  for (double g : {-0.5, 0.0, 0.65, 0.9}) {
    EXPECT_NEAR(moments(g).total, 1.0, 1e-4);
    EXPECT_NEAR(moments(g).mean_cosine, g, 1e-4);
  }
}

TEST(HenyeyGreenstein, IsIsotropicWithoutG) {
  EXPECT_NEAR(henyey_greenstein(0.3, 0.0), 1 / (4 * double(kPi)), 1e-7);
}

TEST(SingleScattering, AmplitudeAndAlphaAreTheSameThingTwice) {
  EXPECT_NEAR(amplitude_from_alpha(alpha_from_amplitude(0.067, 0.65), 0.65), 0.067, 1e-12);
  EXPECT_NEAR(alpha_from_amplitude(0.067, 0.0), 0.067, 1e-12);
}

TEST(SingleScattering, InExactBackscatterCannotTellGFromAlpha) {
  const TransmittanceTable clean;
  const Vec3 n(0, 0, 1), w = unit(Vec3(0.5f, 0.1f, 0.8f));
  const float at_0 = single_scattering(clean, 0.f, n, w, w);
  EXPECT_NEAR(single_scattering(clean, 0.7f, n, w, w), at_0, 1e-5f * at_0);
  const float inside = refracted_cosine(w[2]);
  EXPECT_NEAR(at_0, clean(w[2]) * clean(w[2]) / (4 * kPi * 2 * inside), 1e-5f);
}

TEST(SingleScattering, IsReciprocal) {
  const TransmittanceTable clean;
  const Vec3 n(0, 0, 1), a = unit(Vec3(0.5f, 0.1f, 0.8f)), b = unit(Vec3(-0.3f, 0.6f, 0.4f));
  EXPECT_NEAR(single_scattering(clean, 0.65f, n, a, b), single_scattering(clean, 0.65f, n, b, a),
              1e-7f);
}

TEST(SingleScattering, CosineIsThatOfTheRefractedDirections) {
  const Vec3 n = unit(Vec3(0.1f, 0.2f, 1.f));
  const Vec3 l = unit(Vec3(0.6f, 0.1f, 0.7f)), v = unit(Vec3(-0.2f, 0.3f, 0.9f));
  const float n_l = dot(n, l), n_v = dot(n, v);
  const float expected = -dot(refracted_direction(l, n), refracted_direction(v, n));
  EXPECT_NEAR(scattering_cosine(dot(l, v), n_l, n_v, refracted_cosine(n_l), refracted_cosine(n_v)),
              expected, 1e-5f);
}

// The invariant of eq. 3 with its missing 1/ior^2 put back: no more light leaves than came.
TEST(SingleScattering, ReturnsLessThanItReceives) {
  const TransmittanceTable clean;
  const Vec3 n(0, 0, 1), v = unit(Vec3(0.3f, 0.f, 0.9f));
  const float alpha = 1.f / float(kAlbedoPerAlpha);
  double sum = 0;
  constexpr int kPolar = 60, kAzimuth = 120;
  for (int i = 0; i < kPolar; ++i) {
    const float mu = (float(i) + 0.5f) / kPolar, s = std::sqrt(1 - mu * mu);
    for (int k = 0; k < kAzimuth; ++k) {
      const float azimuth = 2 * kPi * float(k) / kAzimuth;
      const Vec3 l(s * std::cos(azimuth), s * std::sin(azimuth), mu);
      sum += double(single_scattering(clean, 0.f, n, l, v) * mu * alpha);
    }
  }
  EXPECT_LT(sum * 2 * double(kPi) / (kPolar * kAzimuth), 1.0);
}

}  // namespace
}  // namespace lamella::model
