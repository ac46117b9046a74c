// Closed-form numbers of IEC 62471:2006; the clause stands at each.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "test_rig.h"

extern "C" {
#include "budget.h"
#include "dose.h"
}

namespace {

struct dose dose_of(const struct rig& rig) {
  const burst_plan plan = planned(rig);
  return dose_of_burst(&rig, &plan);
}

std::string refusal_of(const struct rig& rig) {
  const burst_plan plan = planned(rig);
  struct budget budget;
  budget_check(&rig, &plan, &budget);
  return budget.refusal;
}

}  // namespace

// 4.3.3: the integral of L_B over time is at most 10^6 J/(m^2 sr). Eight LED steps of 30 ms.
TEST(Dose, OfBlueLightIsWeightedRadianceTimesTheTimeThatLedsAreOn) {
  struct rig rig = test_rig();
  rig.light_led_blue_w_per_m2_sr = 1000;
  EXPECT_NEAR(dose_of(rig).blue_j_per_m2_sr, 1000 * 8 * 0.03, 1e-6);
  EXPECT_EQ(dose_of(rig).bursts_per_day, 4166);  // 10^6 / 240
}

// 4.3.3: 100 W/(m^2 sr) for 10^4 s is the limit, too.
TEST(Dose, LimitOfBlueLightIsThatOfAHundredWattsForTenThousandSeconds) {
  EXPECT_EQ(DOSE_BLUE_LIMIT_J_PER_M2_SR, 100 * 1e4);
}

// 4.3.5: L_R = 50000 / (alpha t^0.25). At alpha = 0.1 rad and 1 s: 500 kW/(m^2 sr); at 1/16 of
// the time, twice that.
TEST(Dose, ThermalLimitFallsWithTheFourthRootOfTime) {
  EXPECT_NEAR(dose_thermal_limit_w_per_m2_sr(0.1, 1e6), 5e5, 1e-6);
  EXPECT_NEAR(dose_thermal_limit_w_per_m2_sr(0.1, 1e6 / 16), 1e6, 1e-6);
}

// 3.2: alpha_min is 1.7 mrad, alpha_max 100 mrad.
TEST(Dose, SourceSubtendsItsDiameterOverTheDistanceWithinBounds) {
  struct rig rig = test_rig();
  rig.light_led_diameter_mm = 5;
  rig.light_eye_distance_mm = 1000;
  EXPECT_DOUBLE_EQ(dose_angular_subtense_rad(&rig), 0.005);
  rig.light_led_diameter_mm = 0.1;
  EXPECT_DOUBLE_EQ(dose_angular_subtense_rad(&rig), 0.0017);
  rig.light_led_diameter_mm = 500;
  EXPECT_DOUBLE_EQ(dose_angular_subtense_rad(&rig), 0.1);
}

TEST(Dose, ABurstBeyondTheLimitOfBlueLightIsRefused) {
  struct rig rig = test_rig();
  rig.light_led_blue_w_per_m2_sr = 1.01e6 / (8 * 0.03);
  EXPECT_NE(refusal_of(rig).find("blue light"), std::string::npos) << refusal_of(rig);
  rig.light_led_blue_w_per_m2_sr = 0.99e6 / (8 * 0.03);
  EXPECT_EQ(refusal_of(rig), "");
}

TEST(Dose, APulseBeyondTheThermalLimitIsRefused) {
  struct rig rig = test_rig();
  rig.light_led_thermal_w_per_m2_sr =
      1.01 * dose_thermal_limit_w_per_m2_sr(dose_angular_subtense_rad(&rig), 30000);
  EXPECT_NE(refusal_of(rig).find("thermal"), std::string::npos) << refusal_of(rig);
}

TEST(Dose, OfEveryRigThatShipsLeavesRoomForAHundredBurstsADay) {
  for (const char* name : {"sim", "slr", "machine_vision", "vm", "pi4", "pi5", "beagleplay"}) {
    EXPECT_GT(dose_of(test_rig(name)).bursts_per_day, 100) << name;
    EXPECT_LT(dose_of(test_rig(name)).thermal_share, 0.1) << name;
  }
}
