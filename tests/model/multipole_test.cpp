#include "model/multipole.h"

#include <gtest/gtest.h>

namespace lamella::model {
namespace {

TEST(Multipole, WithOneDipoleIsTheDipole) {
  const Multipole<double> slab{0.8, 0.9, 0.5};
  for (double r : {0.0, 0.1, 1.0, 5.0}) {
    EXPECT_NEAR(multipole_reflectance(slab, r, 0), dipole_reflectance(Dipole<double>{0.8, 0.9}, r),
                1e-14);
  }
  EXPECT_NEAR(multipole_total(slab, 0), diffuse_reflectance(0.8), 1e-14);
}

TEST(Multipole, TotalIsTheIntegralOverThePlane) {
  const Multipole<double> slab{0.9, 1.0, 0.5};
  double sum = 0;
  const double step = 1e-3;
  for (double t = std::log(1e-6); t < std::log(1e3); t += step) {
    const double r = std::exp(t);
    sum += 2 * M_PI * r * r * multipole_reflectance(slab, r) * step;
  }
  EXPECT_NEAR(sum, multipole_total(slab), 1e-5);
}

TEST(Multipole, FiveDipolesHaveConvergedForTheShallowLayer) {
  const Multipole<double> slab{0.9, 1.0, 0.5};
  const double converged = multipole_total(slab, 200);
  EXPECT_NEAR(multipole_total(slab) / converged, 1, 5e-4);
  EXPECT_LE(half_count_for(slab, 1e-3), kPaperHalfCount);
}

TEST(Multipole, FiveDipolesAreEightPercentHighWhereLittleIsAbsorbed) {
  const Multipole<double> slab{0.99, 2.0, 0.5};
  const double converged = multipole_total(slab, 400);
  EXPECT_NEAR(multipole_total(slab) / converged, 1.08, 0.015);
  EXPECT_GT(half_count_for(slab, 1e-3), kPaperHalfCount);
}

TEST(Multipole, SlabMuchThinnerThanAMeanFreePathReflectsLessThanNothing) {
  EXPECT_NEAR(multipole_total(Multipole<double>{0.9, 1.0, 0.1}, 200), -0.054, 2e-3);
  EXPECT_NEAR(multipole_total(Multipole<double>{0.9, 1.0, 0.3}, 200), 0.062, 2e-3);
}

TEST(Multipole, ThickSlabIsTheHalfSpace) {
  const Multipole<double> slab{0.7, 0.8, 30.0};
  EXPECT_NEAR(multipole_total(slab), diffuse_reflectance(0.7), 1e-9);
  EXPECT_NEAR(multipole_reflectance(slab, 0.7), dipole_reflectance(Dipole<double>{0.7, 0.8}, 0.7),
              1e-9);
}

TEST(Multipole, IsFiniteOnTheAxisAndFarAway) {
  const Multipole<double> slab{0.9, 1.0, 0.5};
  EXPECT_TRUE(std::isfinite(multipole_reflectance(slab, 0.0)));
  EXPECT_NEAR(multipole_reflectance(slab, 60.0), 0, 1e-20);
}

}  // namespace
}  // namespace lamella::model
