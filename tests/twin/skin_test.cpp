#include "twin/skin.h"

#include <gtest/gtest.h>

#include "twin/surface_reflection.h"
#include "twin/truth_fits.h"

namespace lamella::twin {
namespace {

TEST(Profile, IsPositiveAndIntegratesToWhatCameBack) {
  const Skin skin = facial_skins(1)[0];
  const WalkResult walk = walk_photons(slab_of(skin, 0), 20000, 1);
  const Profile profile = profile_from_walk(walk);
  double sum = 0;
  for (int i = 0; i < Profile::kCount; ++i) {
    ASSERT_GT(profile.at(i), 0.f) << i;
    sum += double(profile.at(i)) * 2 * kPi * Profile::radius_mm(i) * Profile::kStep;
  }
  EXPECT_NEAR(sum, walk.reflected[1] + walk.reflected[2], 1e-4);
}

TEST(Skins, DifferByRegionAndBySeedButNotByRun) {
  EXPECT_NE(facial_skins(1)[0].epidermis_mm, facial_skins(1)[4].epidermis_mm);
  EXPECT_NE(facial_skins(1)[0].epidermis_mm, facial_skins(2)[0].epidermis_mm);
  EXPECT_EQ(facial_skins(1)[0].epidermis_mm, facial_skins(1)[0].epidermis_mm);
}

// Sum over the hemisphere of value(direction) * cosine, n = +Z.
template <class Value>
double over_hemisphere(const Value& value) {
  double sum = 0;
  const int rings = 1000, spokes = 60;
  for (int i = 0; i < rings; ++i) {
    const float c = (float(i) + 0.5f) / rings, s = std::sqrt(1 - c * c);
    for (int j = 0; j < spokes; ++j) {
      const float phi = 2 * kPi * (float(j) + 0.5f) / spokes;
      sum += value(Vec3(s * std::cos(phi), s * std::sin(phi), c)) * c;
    }
  }
  return sum * 2 * kPi / (rings * spokes);
}

TEST(SurfaceLobe, HasADistributionThatIsNormalised) {
  for (float m : {0.15f, 0.3f, 0.4f}) {
    EXPECT_NEAR(over_hemisphere([&](const Vec3& h) { return facet_density(h[2], m); }), 1.0, 2e-3);
  }
}

TEST(SurfaceLobe, IsReciprocal) {
  const Vec3 n(0, 0, 1), l = unit({0.5f, 0.2f, 0.8f}), v = unit({-0.3f, 0.4f, 0.6f});
  EXPECT_FLOAT_EQ(surface_lobe(n, l, v, 0.3f), surface_lobe(n, v, l, 0.3f));
  EXPECT_FLOAT_EQ(single_scattering(n, l, v, 0.9f)[1], single_scattering(n, v, l, 0.9f)[1]);
}

TEST(SurfaceLobe, OfACleanInterfaceReflectsAsFresnelSays) {
  // A narrow lobe with the 1/4 of the microfacet model is a mirror.
  EXPECT_NEAR(0.25f * LobeLoss(0.1f)(1.f), fresnel(1.f, 1.f, kIor), 0.1f * 0.0255f);
  EXPECT_NEAR(0.25f * LobeLoss(0.1f)(0.7f), fresnel(0.7f, 1.f, kIor), 0.1f * 0.0325f);
}

TEST(SingleScattering, OfEquationThreeIsWhatThePhotonsDo) {
  const Skin skin = facial_skins(1)[0];
  SlabOptics slab = slab_of(skin, 0);
  slab.lower = slab.upper;
  const int photons = 300000;
  const WalkResult walk = walk_photons(slab, photons, 9);
  const Vec3 n(0, 0, 1);
  const double expected = over_hemisphere([&](const Vec3& v) {
    const float through = (1 - fresnel(1.f, 1.f, kIor)) * (1 - fresnel(v[2], 1.f, kIor));
    return single_albedo(skin, 0) * single_scattering(n, n, v, through)[0];
  });
  const double counted = walk.reflected[size_t(Fate::kSingle)];
  EXPECT_NEAR(counted, expected, 5 * std::sqrt(expected / photons));
}

TEST(NearestDipole, FindsTheDipoleThatMadeTheProfile) {
  Profile profile;
  for (int i = 0; i < Profile::kCount; ++i) {
    profile.deep[size_t(i)] = float(dipole(Profile::radius_mm(i), 0.97, 1.4));
  }
  const DipoleFit fit = nearest_dipole(profile);
  EXPECT_NEAR(fit.ld_mm, 1.4, 1e-3);
  EXPECT_NEAR(fit.alpha, 0.97, 1e-3);
}

TEST(AlphaOfReflectance, UndoesTheIntegralOfTheDipole) {
  double sum = 0;  // of the dipole over the plane
  for (double r = 0.0005; r < 60; r += 0.001) sum += dipole(r, 0.9, 1) * 2 * M_PI * r * 0.001;
  EXPECT_NEAR(alpha_of_reflectance(sum), 0.9, 1e-3);
  EXPECT_TRUE(std::isnan(alpha_of_reflectance(1.2)));
}

TEST(GaussianWidth, FindsTheWidthOfAGaussian) {
  std::vector<double> theta, p;
  for (int i = 0; i <= 90; ++i) {
    theta.push_back(i * M_PI / 360);
    p.push_back(3.3 * std::exp(-std::pow(theta.back() / 0.27, 2)));
  }
  EXPECT_NEAR(gaussian_width(theta, p), 0.27, 1e-6);
}

}  // namespace
}  // namespace lamella::twin
