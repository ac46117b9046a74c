#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "test_rig.h"

extern "C" {
#include "budget.h"
#include "plan.h"
#include "safety.h"
#include "timeline.h"
}

namespace {

struct budget budget_of(const struct rig& rig) {
  const burst_plan plan = planned(rig);
  struct budget budget;
  budget_check(&rig, &plan, &budget);
  return budget;
}

bool refuses(const struct rig& rig, const std::string& words) {
  return std::string(budget_of(rig).refusal).find(words) != std::string::npos;
}

lamella_v1_Plan described(const struct rig& rig) {
  lamella_v1_Plan plan;
  plan_describe(&rig, &plan);
  return plan;
}

}  // namespace

TEST(Budget, DoublesWhiteWithTheLightAndQuartersItWithTheAperture) {
  struct rig rig = test_rig();
  const double share = budget_of(rig).leds_share;
  rig.light_leds_lux *= 2;
  EXPECT_NEAR(budget_of(rig).leds_share, 2 * share, 1e-9);
  rig.camera_f_number *= 2;
  EXPECT_NEAR(budget_of(rig).leds_share, share / 2, 1e-9);
}

TEST(Budget, OfOneLuxSecondAtIso78OpensASensorByTheStandardsFactor) {
  struct rig rig = test_rig();
  rig.light_leds_lux = 3.14159265358979 / 0.03;  // luminance 1/0.03 cd/m^2, for 30 ms
  rig.camera_analyser_transmission = rig.camera_f_number = 1;
  rig.camera_iso = 78;
  EXPECT_NEAR(budget_of(rig).leds_share, 0.65, 1e-9);
}

TEST(Budget, RefusesAnExposureThatTheLightDoesNotSupport) {
  struct rig rig = test_rig();
  rig.light_projector_lux = 10;
  EXPECT_TRUE(refuses(rig, "light.projector_lux exposes white to"));
}

TEST(Budget, RefusesLedsThatGetTooHot) {
  struct rig rig = test_rig();
  rig.leds_power_w = 60;
  EXPECT_TRUE(refuses(rig, "leds.highest_junction_c is 105 C"));
  rig.leds_thermal_time_us = 3600e6;  // a heavy heat sink
  EXPECT_STREQ(budget_of(rig).refusal, "");
}

TEST(Budget, JunctionOfSlowHeatSinkRisesByTheEnergyOverItsCapacity) {
  struct rig rig = test_rig();
  rig.leds_thermal_time_us = 3600e6;
  const double joules = 8 * 0.03 * rig.leds_power_w;
  const double capacity = rig.leds_thermal_time_us * 1e-6 / rig.leds_thermal_k_per_w;
  EXPECT_NEAR(budget_of(rig).junction_c - rig.leds_ambient_c, joules / capacity, 1e-6);
}

TEST(Budget, RefusesMoreFramesThanMemoryAndDiskTake) {
  struct rig rig = test_rig();
  rig.camera_frame_bytes = 15116544;
  EXPECT_TRUE(refuses(rig, "605 MB of photographs"));
  rig.store_disk_bytes_per_s = 400e6;  // over a second of burst
  EXPECT_STREQ(budget_of(rig).refusal, "");
}

TEST(Plan, OfEveryRigFileThatShipsIsSafeAndWithinItsBudget) {
  for (const char* name : {"sim", "slr", "machine_vision", "pi4", "pi5", "beagleplay"}) {
    EXPECT_STREQ(described(test_rig(name)).refusal, "") << name;
  }
}

TEST(Plan, OfSlrTakesAboutThePapersFiveSeconds) {
  EXPECT_NEAR(described(test_rig("slr")).duration_us, 5e6, 0.5e6);
}

TEST(Plan, OfMachineVisionTakesLessThanASecond) {
  EXPECT_LT(described(test_rig("machine_vision")).duration_us, 1e6);
}

TEST(Plan, WaitsAndExposuresAddUpToTheWhole) {
  for (const char* name : {"sim", "slr", "machine_vision"}) {
    const struct rig rig = test_rig(name);
    const lamella_v1_Plan plan = described(rig);
    double sum_us = rig.camera_readout_us;
    for (size_t i = 0; i < plan.steps_count; i++) {
      sum_us += plan.steps[i].wait_us + plan.steps[i].close_us - plan.steps[i].open_us;
    }
    EXPECT_NEAR(sum_us, plan.duration_us, 1e-3) << name;
  }
}

TEST(OverlappedReadout, IsOverWhenTheNextExposureCloses) {
  const struct rig rig = test_rig("machine_vision");
  const burst_plan plan = planned(rig);
  for (size_t i = 1; i < plan.count; i++) {
    EXPECT_GE(plan.times[i].close_us, plan.times[i - 1].close_us + rig.camera_readout_us);
  }
  struct rig sequential = rig;
  sequential.camera_readout_overlaps = false;
  EXPECT_GT(planned(sequential).duration_us, plan.duration_us + 100000);
}

TEST(OverlappedReadout, RefusesAnExposureThatClosesDuringIt) {
  struct rig rig = test_rig("machine_vision");
  const burst_plan plan = planned(rig);
  struct timeline timeline;
  timeline_build(&rig, &plan, &timeline);
  struct safety_finding finding;
  ASSERT_EQ(safety_check(&rig, &timeline, &finding), LAM_OK) << finding.text;
  rig.camera_readout_us += 1000;
  ASSERT_EQ(safety_check(&rig, &timeline, &finding), LAM_UNSAFE);
  EXPECT_EQ(finding.rule, SAFETY_READOUT);
}
