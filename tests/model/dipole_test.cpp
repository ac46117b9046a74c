#include "model/dipole.h"

#include <gtest/gtest.h>

#include <complex>

namespace lamella::model {
namespace {

// Integral of a radial profile over the plane, rings at equal steps of log r.
template <class Profile>
double plane_integral(const Profile& profile) {
  double sum = 0;
  const double step = 1e-3;
  for (double t = std::log(1e-6); t < std::log(1e3); t += step) {
    const double r = std::exp(t);
    sum += 2 * M_PI * r * r * profile(r) * step;
  }
  return sum;
}

class DipoleOfAlbedo : public testing::TestWithParam<double> {};

TEST_P(DipoleOfAlbedo, IntegratesOverThePlaneToEquationEight) {
  const Dipole<double> m{GetParam(), 1.3};
  const double total = plane_integral([&](double r) { return dipole_reflectance(m, r); });
  EXPECT_NEAR(total, diffuse_reflectance(m.alpha), 2e-5 * total);
}

TEST_P(DipoleOfAlbedo, InverseOfEquationEightReturnsTheAlbedo) {
  const auto alpha = alpha_from_reflectance(diffuse_reflectance(GetParam()));
  ASSERT_TRUE(alpha);
  EXPECT_NEAR(*alpha, GetParam(), 1e-9);
}

TEST_P(DipoleOfAlbedo, IsFiniteOnTheAxisAndVanishesFarAway) {
  const Dipole<double> m{GetParam(), 0.7};
  EXPECT_TRUE(std::isfinite(dipole_reflectance(m, 0.0)));
  EXPECT_GT(dipole_reflectance(m, 0.0), dipole_reflectance(m, 0.1));
  EXPECT_LT(dipole_reflectance(m, 100 * m.ld_mm), 1e-30);
}

INSTANTIATE_TEST_SUITE_P(FromDarkToWhite, DipoleOfAlbedo, testing::Values(0.1, 0.5, 0.9, 0.999));

TEST(DiffuseReflectance, RisesFromNothingToEverything) {
  EXPECT_NEAR(diffuse_reflectance(0), 0, 1e-12);
  EXPECT_NEAR(diffuse_reflectance(1), 1, 1e-12);
  EXPECT_NEAR(diffuse_reflectance(0.9999), 0.9487, 1e-3);
  double last = -1;
  for (double alpha = 0; alpha <= 1; alpha += 0.01) {
    EXPECT_GT(diffuse_reflectance(alpha), last);
    last = diffuse_reflectance(alpha);
  }
}

TEST(DiffuseReflectance, OneOrMoreHasNoAlbedo) {
  EXPECT_FALSE(alpha_from_reflectance(1.0));
  EXPECT_FALSE(alpha_from_reflectance(1.7));
  EXPECT_FALSE(alpha_from_reflectance(std::nan("")));
  EXPECT_TRUE(std::isnan(AlphaTable().alpha(1.0f)));
}

TEST(DiffuseReflectance, LightThatIsNotThereHasAlbedoZero) {
  EXPECT_EQ(*alpha_from_reflectance(-0.01), 0);
  EXPECT_EQ(AlphaTable().alpha(-0.01f), 0);
}

TEST(DiffuseReflectance, TableAgreesWithTheExactInverse) {
  const AlphaTable table;
  for (double reflectance = 0.01; reflectance < 0.99; reflectance += 0.0037) {
    EXPECT_NEAR(table.alpha(float(reflectance)), *alpha_from_reflectance(reflectance), 5e-6);
  }
}

// The step in the imaginary direction is the exact derivative of the same template.
TEST(Dipole, DerivativesAgreeWithFiniteDifferences) {
  using Complex = std::complex<double>;
  const double alpha = 0.87, ld = 1.4, r = 0.6, h = 1e-6;
  const auto exact = [&](const Complex& a, const Complex& l) {
    return dipole_reflectance(Dipole<Complex>{a, l}, r).imag() / 1e-20;
  };
  const auto at = [&](double a, double l) { return dipole_reflectance(Dipole<double>{a, l}, r); };
  EXPECT_NEAR(exact({alpha, 1e-20}, ld), (at(alpha + h, ld) - at(alpha - h, ld)) / (2 * h), 1e-7);
  EXPECT_NEAR(exact(alpha, {ld, 1e-20}), (at(alpha, ld + h) - at(alpha, ld - h)) / (2 * h), 1e-7);
}

}  // namespace
}  // namespace lamella::model
