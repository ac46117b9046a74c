#include "fit/region_lean.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lamella::fit {
namespace {

DeepProfile measured(double ld_mm, double relative_stddev) {
  DeepProfile deep;
  deep.ld_mm = ld_mm;
  deep.ld_mm_stddev = ld_mm * relative_stddev;
  return deep;
}

TEST(RegionLean, WhatIsHardlyKnownGoesWhereTheOthersAre) {
  const auto leaned = leaned_on_each_other(
      {measured(0.55, 0.05), measured(0.60, 0.05), measured(0.5, 0.06), measured(2.27, 0.87)});
  EXPECT_NEAR(leaned[3].ld_mm, 0.6, 0.06);
  EXPECT_LT(leaned[3].ld_mm_stddev / leaned[3].ld_mm, kRegionSpread);
}

TEST(RegionLean, WhatIsKnownStaysThoughItIsNotAsTheOthers) {
  const auto leaned =
      leaned_on_each_other({measured(2.9, 0.04), measured(2.0, 0.04), measured(1.9, 0.04)});
  EXPECT_NEAR(leaned[0].ld_mm, 2.9, 0.015 * 2.9);
  EXPECT_NEAR(leaned[1].ld_mm, 2.0, 0.01 * 2.0);
}

TEST(RegionLean, NeverMakesADeviationLarger) {
  for (const double relative : {0.0, 0.01, 0.1, 1.0, 5.0}) {
    const auto leaned = leaned_on_each_other({measured(1, relative), measured(1, 0.05)});
    EXPECT_LE(leaned[0].ld_mm_stddev, relative * (1 + 1e-12));
    EXPECT_TRUE(std::isfinite(leaned[0].ld_mm_stddev));
  }
}

TEST(RegionLean, OneAloneStaysAsItIs) {
  const auto leaned = leaned_on_each_other({measured(1.3, 2)});
  EXPECT_EQ(leaned[0].ld_mm, 1.3);
  EXPECT_EQ(leaned[0].ld_mm_stddev, 2.6);
  EXPECT_TRUE(leaned_on_each_other({}).empty());
}

}  // namespace
}  // namespace lamella::fit
