#include "model/half_space.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "half_space_walk.h"
#include "model/diffuse_reflectance.h"

namespace lamella::model {
namespace {

using testing::HalfSpaceWalk;
using Table = HalfSpaceTable;

TEST(HalfSpace, IsWhatAShortWalkFinds) {
  HalfSpaceWalk walk(0.67);
  walk.walk(4000, 7);
  for (int i = 4; i < 12; i += 3) {
    EXPECT_NEAR(walk.reflectance(i), half_space_reflectance(Table::log_absorption(i)), 0.03);
    const HalfSpaceTransfer transfer(Table::log_absorption(i));
    for (int j = 4; j < 20; j += 3) {
      EXPECT_NEAR(walk.transfer(i, j + 1), transfer(Table::log_frequency(j)), 0.03)
          << "absorption " << i << ", frequency " << j;
    }
  }
}

// Prints model/half_space_table.inc, save for its braces; many minutes.
TEST(HalfSpace, DISABLED_IsWalkedAnew) {
  HalfSpaceWalk walk(0.67);
  walk.walk(5000000, 101);
  for (int i = 0; i < Table::kAbsorptions; ++i) {
    std::printf("%.4f", walk.reflectance(i));
    for (int j = 0; j < Table::kFrequencies; ++j) std::printf(", %.4f", walk.transfer(i, j + 1));
    std::printf("\n");
  }
}

TEST(HalfSpace, ReflectsAboutWhatTheDipoleDoesLessWhatScattersOnce) {
  for (double log_absorption : {-4.0, -3.0, -2.0}) {
    const double alpha = 1 / (1 + std::exp(log_absorption));
    const double excess = diffuse_reflectance(alpha) - half_space_reflectance(log_absorption);
    EXPECT_GT(excess, 0);
    EXPECT_LT(excess, 0.06);
  }
}

TEST(HalfSpace, AbsorptionOfAReflectanceIsTheInverse) {
  for (double log_absorption = -6; log_absorption < 1; log_absorption += 0.37) {
    EXPECT_NEAR(log_absorption_of(half_space_reflectance(log_absorption)), log_absorption, 1e-6);
  }
  EXPECT_GE(log_absorption_of(0.99), Table::log_absorption(0)) << "held at the table's end";
  EXPECT_LE(log_absorption_of(1e-9), Table::log_absorption(Table::kAbsorptions - 1));
}

TEST(HalfSpace, LeavesLongWavesAndFallsWithFrequency) {
  for (double log_absorption : {-5.0, -2.75, -0.4}) {
    const HalfSpaceTransfer transfer(log_absorption);
    EXPECT_NEAR(transfer(-6), 1, 0.01);
    for (double f = -6; f < 0; f += 0.1) EXPECT_LT(transfer(f + 0.1), transfer(f) + 1e-4) << f;
  }
}

}  // namespace
}  // namespace lamella::model
