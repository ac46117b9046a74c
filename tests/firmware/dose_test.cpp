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

struct dose leds_dose(const struct rig& rig) {
  const burst_plan plan = planned(rig);
  return dose_of_leds(&rig, &plan);
}

struct dose projector_dose(const struct rig& rig) {
  const burst_plan plan = planned(rig);
  return dose_of_projector(&rig, &plan);
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
  EXPECT_NEAR(leds_dose(rig).blue_j_per_m2_sr, 1000 * 8 * 0.03, 1e-6);
  EXPECT_EQ(leds_dose(rig).bursts_per_day, 4166);  // 10^6 / 240
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
  EXPECT_EQ(dose_thermal_limit_w_per_m2_sr(0.1, 60e6), dose_thermal_limit_w_per_m2_sr(0.1, 10e6));
}

// 3.2: alpha_min is 1.7 mrad, alpha_max 100 mrad.
TEST(Dose, SourceSubtendsItsDiameterOverTheDistanceWithinBounds) {
  EXPECT_DOUBLE_EQ(dose_angular_subtense_rad(5, 1000), 0.005);
  EXPECT_DOUBLE_EQ(dose_angular_subtense_rad(0.1, 1000), 0.0017);
  EXPECT_DOUBLE_EQ(dose_angular_subtense_rad(500, 1000), 0.1);
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
      1.01 * dose_thermal_limit_w_per_m2_sr(0.002, 30000);  // 2 mm at 1 m
  EXPECT_NE(refusal_of(rig).find("thermal"), std::string::npos) << refusal_of(rig);
}

namespace {

// LED, two projector steps, LED, projector: the lamp is lit from 50 to 190 ms and from 300 to 355
// ms, and takes 5 ms to go dark.
burst_plan plan_with_lamp() {
  burst_plan plan = {};
  plan.count = 5;
  plan.steps[0].role = plan.steps[3].role = lamella_v1_Frame_Role_GRADIENT_FULL;
  plan.steps[1].role = plan.steps[2].role = lamella_v1_Frame_Role_FRINGE;
  plan.steps[4].role = lamella_v1_Frame_Role_DOTS;
  plan.times[1].lamp_us = 50e3;
  plan.times[1].close_us = 100e3;
  plan.times[2].close_us = 190e3;
  plan.times[3].lamp_us = 190.05e3;
  plan.times[4].lamp_us = 300e3;
  plan.times[4].close_us = 355e3;
  return plan;
}

struct rig rig_with_projector() {
  struct rig rig = test_rig();
  rig.projector_lamp_settle_us = 5e3;
  rig.light_projector_blue_w_per_m2_sr = 20000;
  rig.light_projector_thermal_w_per_m2_sr = 1e6;
  rig.light_projector_pupil_mm = 8;
  rig.light_projector_eye_distance_mm = 1000;
  return rig;
}

}  // namespace

// Lit for 145 + 60 ms, at 20 kW/(m^2 sr): 4100 J/(m^2 sr).
TEST(Dose, OfTheProjectorIsWeightedRadianceTimesTheTimeThatItsLampIsOn) {
  const struct rig rig = rig_with_projector();
  const burst_plan plan = plan_with_lamp();
  const struct dose dose = dose_of_projector(&rig, &plan);
  EXPECT_NEAR(dose.blue_j_per_m2_sr, 4100, 1e-9);
  EXPECT_EQ(dose.bursts_per_day, 243);  // 10^6 / 4100
}

// 8 mm at 1 m for 145 ms: 50000 / (0.008 x 0.61708) = 1.01283e7 W/(m^2 sr).
TEST(Dose, ThermalShareOfTheProjectorIsThatOfTheLongestTimeThatItsLampIsOn) {
  const struct rig rig = rig_with_projector();
  const burst_plan plan = plan_with_lamp();
  EXPECT_NEAR(dose_of_projector(&rig, &plan).thermal_share, 0.098733, 1e-6);
}

// A take ends with its lamp dark, whatever the next one begins with: 145 and 60 ms again.
TEST(Dose, OfTheProjectorDoesNotCountWhatLiesBetweenTakes) {
  const struct rig rig = rig_with_projector();
  burst_plan plan = plan_with_lamp();
  plan.steps[3] = plan.steps[4];
  plan.times[3] = plan.times[4];
  plan.count = 4;
  EXPECT_NEAR(dose_of_projector(&rig, &plan).blue_j_per_m2_sr, 4100, 1e-9);
}

TEST(Dose, OfABurstWithoutProjectorIsNone) {
  const struct rig rig = rig_with_projector();
  burst_plan plan = plan_with_lamp();
  plan.count = 1;
  EXPECT_EQ(dose_of_projector(&rig, &plan).blue_j_per_m2_sr, 0);
}

TEST(Dose, AProjectorBeyondALimitIsRefusedAndNamed) {
  struct rig rig = test_rig();
  const double lit_s = projector_dose(rig).blue_j_per_m2_sr / rig.light_projector_blue_w_per_m2_sr;
  rig.light_projector_blue_w_per_m2_sr = 1.01e6 / lit_s;
  EXPECT_NE(refusal_of(rig).find("looks into the projector's lens"), std::string::npos)
      << refusal_of(rig);
  rig = test_rig();
  rig.light_projector_thermal_w_per_m2_sr *= 1.01 / projector_dose(rig).thermal_share;
  EXPECT_NE(refusal_of(rig).find("thermal: the longest pulse of the projector's lens"),
            std::string::npos)
      << refusal_of(rig);
}

TEST(Dose, OfLedsAndProjectorAreNotAddedAsTheirImagesOnTheRetinaAreTwo) {
  struct rig rig = test_rig();
  rig.light_led_blue_w_per_m2_sr *= 0.9e6 / leds_dose(rig).blue_j_per_m2_sr;
  rig.light_projector_blue_w_per_m2_sr *= 0.9e6 / projector_dose(rig).blue_j_per_m2_sr;
  EXPECT_EQ(refusal_of(rig), "");
}

TEST(Dose, OfLedsOfEveryRigThatShipsLeavesRoomForAHundredBurstsADay) {
  for (const char* name : {"sim", "slr", "machine_vision", "vm", "pi4", "pi5", "beagleplay"}) {
    EXPECT_GT(leds_dose(test_rig(name)).bursts_per_day, 100) << name;
    EXPECT_LT(leds_dose(test_rig(name)).thermal_share, 0.1) << name;
  }
}

// White all the time, and an eye that never looks away from the lens.
TEST(Dose, OfEveryProjectorThatShipsLeavesRoomForTenBurstsADay) {
  for (const char* name : {"sim", "slr", "machine_vision", "vm", "pi4", "pi5", "beagleplay"}) {
    EXPECT_GE(projector_dose(test_rig(name)).bursts_per_day, 10) << name;
    EXPECT_LT(projector_dose(test_rig(name)).thermal_share, 0.3) << name;
  }
}
