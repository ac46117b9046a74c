#include "twin/photon_walk.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lamella::twin {
namespace {

constexpr int kPhotons = 200000;

TEST(PhotonWalk, ReproducesVanDeHulstsSlab) {
  const SlabOptics slab{
      .upper = {.absorption_per_mm = 1, .scattering_per_mm = 9, .g = 0.75f, .thickness_mm = 0.2f},
      .lower = {.thickness_mm = 0},
      .ior = 1.f};
  const WalkResult walk = walk_photons(slab, kPhotons, 1);
  EXPECT_NEAR(walk.diffuse_reflectance(), 0.09739, 4 * std::sqrt(0.09739 / kPhotons));
  EXPECT_NEAR(walk.transmitted, 0.66096, 4 * std::sqrt(0.24 / kPhotons));
  EXPECT_NEAR(walk.unscattered, std::exp(-2.0), 4 * std::sqrt(0.12 / kPhotons));
}

TEST(PhotonWalk, SplitsVanDeHulstsSlabInTwoWithoutChangingIt) {
  const LayerOptics half{
      .absorption_per_mm = 1, .scattering_per_mm = 9, .g = 0.75f, .thickness_mm = 0.1f};
  const WalkResult walk = walk_photons({.upper = half, .lower = half, .ior = 1.f}, kPhotons, 2);
  EXPECT_NEAR(walk.diffuse_reflectance(), 0.09739, 4 * std::sqrt(0.09739 / kPhotons));
  EXPECT_NEAR(walk.transmitted, 0.66096, 4 * std::sqrt(0.24 / kPhotons));
}

TEST(PhotonWalk, UnderAnUpperLayerOfNoThicknessIsThatOfTheLowerOneAlone) {
  const LayerOptics skin{.absorption_per_mm = 0.2f, .scattering_per_mm = 8, .g = 0.7f};
  LayerOptics nothing = skin;
  nothing.thickness_mm = 0;
  const WalkResult alone = walk_photons({.upper = skin, .lower = {}}, kPhotons, 6);
  const WalkResult below = walk_photons({.upper = nothing, .lower = skin}, kPhotons, 7);
  EXPECT_EQ(below.reflected[size_t(Fate::kShallow)], 0.0);
  EXPECT_NEAR(below.reflected[size_t(Fate::kSingle)], alone.reflected[size_t(Fate::kSingle)],
              5 * std::sqrt(2 * alone.reflected[size_t(Fate::kSingle)] / kPhotons));
  EXPECT_NEAR(below.diffuse_reflectance(), alone.diffuse_reflectance(),
              5 * std::sqrt(0.5 / kPhotons));
}

TEST(PhotonWalk, ReproducesGiovanellisSemiInfiniteMedium) {
  const SlabOptics slab{
      .upper = {.absorption_per_mm = 1, .scattering_per_mm = 9, .g = 0}, .lower = {}, .ior = 1.5f};
  const WalkResult walk = walk_photons(slab, kPhotons, 3);
  EXPECT_NEAR(walk.surface + walk.diffuse_reflectance(), 0.2600, 4 * std::sqrt(0.2 / kPhotons));
}

TEST(PhotonWalk, KeepsEnergy) {
  const SlabOptics skin{.upper = {.absorption_per_mm = 0.2f,
                                  .scattering_per_mm = 10,
                                  .g = 0.66f,
                                  .thickness_mm = 0.15f},
                        .lower = {.absorption_per_mm = 0.1f, .scattering_per_mm = 7, .g = 0.66f}};
  const WalkResult walk = walk_photons(skin, 40000, 4);
  EXPECT_NEAR(walk.surface + walk.diffuse_reflectance() + walk.absorbed + walk.transmitted, 1.0,
              2e-4);
  EXPECT_EQ(walk.transmitted, 0.0);
}

TEST(PhotonWalk, ScattersOnceAsTheFirstOrderIntegralSays) {
  // Matched index, isotropic, normal incidence: the light scattered exactly once comes back as
  // albedo/2 * integral over mu of mu/(1+mu) = albedo/2 (1 - ln 2).
  const SlabOptics slab{
      .upper = {.absorption_per_mm = 2, .scattering_per_mm = 8, .g = 0}, .lower = {}, .ior = 1.f};
  const WalkResult walk = walk_photons(slab, kPhotons, 5);
  EXPECT_NEAR(walk.reflected[size_t(Fate::kSingle)], 0.4 * (1 - std::log(2.0)),
              4 * std::sqrt(0.12 / kPhotons));
}

TEST(PhotonWalk, RepeatsItselfForTheSameSeedAndNotForAnother) {
  const SlabOptics slab{.upper = {.absorption_per_mm = 1, .scattering_per_mm = 9}, .lower = {}};
  const double a = walk_photons(slab, 1000, 7).diffuse_reflectance();
  EXPECT_EQ(a, walk_photons(slab, 1000, 7).diffuse_reflectance());
  EXPECT_NE(a, walk_photons(slab, 1000, 8).diffuse_reflectance());
}

}  // namespace
}  // namespace lamella::twin
