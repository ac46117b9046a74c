// Where the model's formulas end. Each case names what fails where it is not seen to. Others stand
// beside what they are limits of: alpha' at 0.999 and R_d of 1 and more in dipole_test.cpp; slabs
// too thin for diffusion, r of 0 and far beyond l_d in multipole_test.cpp.
#include <gtest/gtest.h>

#include "model/multipole.h"
#include "model/single_scattering.h"
#include "model/torrance_sparrow.h"

namespace lamella::model {
namespace {

const std::vector<double> kRadii_mm{0, 1e-9, 1e-3, 0.1, 8, 1e4};

// Failure: both sources rise to the surface, where their distance to the axis is 0.
TEST(ModelLimits, AMediumThatAbsorbsNextToNothingHasAProfileOfNumbers) {
  for (const double absorbed : {1e-4, 1e-8, 1e-12}) {
    for (const double r_mm : kRadii_mm) {
      const double value = dipole_reflectance(Dipole<double>{1 - absorbed, 1.0}, r_mm);
      EXPECT_TRUE(std::isfinite(value)) << absorbed << " at " << r_mm;
      EXPECT_GE(value, 0) << absorbed << " at " << r_mm;
    }
    EXPECT_LT(diffuse_reflectance(1 - absorbed), 1);
  }
}

// Failure: a logarithm or quotient of the nothing that is reflected.
TEST(ModelLimits, ABlackMediumReflectsNothingAtAnyRadius) {
  for (const double r_mm : kRadii_mm) {
    EXPECT_EQ(dipole_reflectance(Dipole<double>{0.0, 1.0}, r_mm), 0);
    EXPECT_EQ(multipole_reflectance(Multipole<double>{0.0, 1.0, 0.5}, r_mm), 0);
  }
  EXPECT_EQ(multipole_total(Multipole<double>{0.0, 1.0, 0.5}), 0);
}

// Failure: the series of a slab whose total passes through 0 never falls below a share of it.
TEST(ModelLimits, TheSeriesOfASlabOfNoThicknessEndsAtItsLimit) {
  for (const double thickness_mm : {0.0, 0.1, 0.2, 0.21, 0.22, 0.25}) {
    const Multipole<double> slab{0.9, 1.0, thickness_mm};
    EXPECT_EQ(half_count_for(slab, 0, 4), 4) << thickness_mm;
    EXPECT_TRUE(std::isfinite(multipole_total(slab, 64))) << thickness_mm;
  }
}

// Failure: 1 + g^2 - 2 g cos is the difference of numbers that are nearly equal.
TEST(ModelLimits, AsymmetryAtTheFitsBoundsStillIntegratesInSinglePrecision) {
  for (const float g : {-0.99f, 0.f, 0.99f}) {
    for (const float cosine : {-1.f, -0.999f, 0.f, 0.999f, 1.f}) {
      const double exact = henyey_greenstein(double(cosine), double(g));
      EXPECT_NEAR(henyey_greenstein(cosine, g), exact, 0.01 * exact) << g << " " << cosine;
    }
  }
}

// Failure: an amplitude asks for an albedo without end.
TEST(ModelLimits, ForwardScatteringAloneHasNoAmplitude) {
  EXPECT_EQ(amplitude_from_alpha(0.9, 1.0), 0);
  EXPECT_TRUE(std::isfinite(alpha_from_amplitude(0.067, 0.99)));
  EXPECT_GT(amplitude_from_alpha(0.9, -0.9), amplitude_from_alpha(0.9, 0.9));
}

Vec3 towards(double degrees_from_normal, double azimuth_degrees) {
  const double theta = degrees_from_normal * M_PI / 180, phi = azimuth_degrees * M_PI / 180;
  return {float(std::sin(theta) * std::cos(phi)), float(std::sin(theta) * std::sin(phi)),
          float(std::cos(theta))};
}

LobeTable gaussian_table(double m) {
  std::vector<double> theta, p;
  for (int i = 0; i <= 90; ++i) {
    theta.push_back(M_PI / 4 * i / 90);
    p.push_back(std::exp(-theta.back() * theta.back() / (m * m)));
  }
  return {theta, p};
}

// Failure: the lobe is over (l.n)(v.n), which nothing but the grooves' shadow holds in bounds.
TEST(ModelLimits, GrazingLightAndViewFromAnySideGiveNumbers) {
  const LobeTable lobe = gaussian_table(0.3);
  const TransmittanceTable clean;
  const Vec3 n(0, 0, 1);
  for (const double grazing : {89.0, 89.99, 89.9999, 90.0, 90.001}) {
    for (const double azimuth : {0.0, 1.0, 90.0, 179.999, 180.0}) {
      const Vec3 l = towards(grazing, 0);
      for (const Vec3& v : {towards(grazing, azimuth), towards(0, azimuth)}) {
        const float surface = torrance_sparrow(lobe, n, l, v);
        EXPECT_TRUE(std::isfinite(surface) && surface >= 0) << grazing << " " << azimuth;
        const Vec3 h = unit(l + v);
        const float bound = 2.01f * lobe.density(1) * h[2] / dot(v, h);
        if (l[2] > 0) {
          EXPECT_LE(surface * l[2], bound) << grazing << " " << azimuth;
        }
        const float single = single_scattering(clean, 0.65f, n, l, v);
        EXPECT_TRUE(std::isfinite(single) && single >= 0) << grazing << " " << azimuth;
      }
    }
  }
}

TEST(ModelLimits, LightFromBelowTheSurfaceOrAgainstTheViewIsNone) {
  const LobeTable lobe = gaussian_table(0.3);
  const Vec3 n(0, 0, 1), v = towards(30, 0);
  EXPECT_EQ(torrance_sparrow(lobe, n, -v, v), 0);
  EXPECT_EQ(single_scattering(TransmittanceTable(), 0.65f, n, -v, v), 0);
}

// Failure: a lobe is divided by its own integral, and its tail goes on with the logarithm of its
// end.
TEST(ModelLimits, ALobeOfNothingIsNothingAndOneThatEndsInNothingIsNormalised) {
  const std::vector<double> theta{0, 0.2, 0.4, 0.785};
  const LobeTable none(theta, {0, 0, 0, 0});
  const LobeTable cut(theta, {1, 0.5, 0, 0});
  for (const float cosine : {-0.5f, 0.f, 0.5f, 1.f}) {
    EXPECT_EQ(none.density(cosine), 0);
    EXPECT_TRUE(std::isfinite(cut.density(cosine)));
  }
  EXPECT_GT(cut.density(1.f), 1.f);
  EXPECT_TRUE(std::isfinite(gaussian_width(theta, {0, 0, 0, 0})));
  EXPECT_EQ(TransmittanceTable(none, 0.3)(0.5f), 1);
}

// Failure: more than all light is reflected, and less than none enters.
TEST(ModelLimits, ASurfaceOfMuchTooHighAnIntensityLetsNothingThroughAndNotLess) {
  const TransmittanceTable mirror(gaussian_table(0.3), 50);
  for (const float cosine : {0.f, 0.3f, 1.f}) {
    EXPECT_GE(mirror(cosine), 0) << cosine;
    EXPECT_LE(mirror(cosine), 1) << cosine;
  }
}

// Failure: rounding takes the cosine of two unit vectors past 1, and the sine is imaginary.
TEST(ModelLimits, ACosineThatRoundingTookPastOneStillHasAFresnelTerm) {
  const float past_one = std::nextafter(1.f, 2.f);
  EXPECT_NEAR(fresnel_reflectance(past_one), float(fresnel_at_normal()), 1e-6f);
  EXPECT_NEAR(refracted_cosine(past_one), 1, 1e-6f);
  EXPECT_TRUE(std::isfinite(gaussian_table(0.3).density(past_one)));
}

}  // namespace
}  // namespace lamella::model
