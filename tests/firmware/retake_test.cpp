// What went wrong is taken again in the same burst.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "session_bench.h"

extern "C" {
#include "dose.h"
}

namespace {

sim_faults one_late_pulse(int pulse, double late_us = 60) {
  sim_faults faults = kSimNoFaults;
  faults.late_blank_us = late_us;
  faults.late_pulse = pulse;
  return faults;
}

sim_faults one_dropped_shot(int shot) {
  sim_faults faults = kSimNoFaults;
  faults.dropped_shot = shot;
  return faults;
}

const struct shot& good_shot_of(const struct roll& roll, size_t place) {
  size_t at = 0;
  while (roll.shots[at].place != place || roll.shots[at].replaced_by >= 0) at++;
  return roll.shots[at];
}

}  // namespace

TEST(Retake, OneLateEdgeIsTakenAgainAndTheBurstIsGood) {
  Bench bench(one_late_pulse(3));
  const lamella_v1_BurstDone& done = bench.burst();
  EXPECT_FALSE(done.marked) << done.verdict;
  EXPECT_EQ(done.late_edges, 1u);
  EXPECT_GE(done.retaken, 1u);
  EXPECT_EQ(done.frame_count, 40 + 2 * done.retaken);
  EXPECT_NE(std::string(done.verdict).find("BLANK of step"), std::string::npos) << done.verdict;
  EXPECT_NE(std::string(done.verdict).find("by 60 us"), std::string::npos) << done.verdict;
}

TEST(Retake, TheBadFrameIsKeptAndSaysWhichShotReplacesIt) {
  Bench bench(one_late_pulse(3));
  bench.burst();
  int marked = 0;
  for (size_t i = 0; i < bench.photographs.count; i++) {
    const struct photograph& bad = bench.photographs.photographs[i];
    if (!bad.frame.has_replaced_by) {
      EXPECT_FALSE(bad.marked);
      continue;
    }
    const struct photograph* good =
        store_find(&bench.photographs, 2 * bad.frame.replaced_by + bad.frame_id % 2);
    ASSERT_NE(good, nullptr);
    EXPECT_FALSE(good->marked);
    EXPECT_EQ(good->frame.step, bad.frame.step);
    EXPECT_EQ(good->frame.role, bad.frame.role);
    EXPECT_EQ(good->frame.analyser, bad.frame.analyser);
    EXPECT_GT(good->frame.trigger_us, bad.frame.trigger_us);
    const double lit_us = good->frame.light_off_us - good->frame.light_on_us;
    EXPECT_NEAR(lit_us, bench.rig.leds_light_us, 1);
    if (!bad.marked) continue;  // a partner that came along
    marked++;
    EXPECT_NEAR(bad.frame.light_off_us - bad.frame.light_on_us, bench.rig.leds_light_us - 60, 1);
  }
  EXPECT_EQ(marked, 2);  // both cameras saw the late light
}

TEST(Retake, EveryEdgeOfBothTakesIsInTheTimingOnOneClock) {
  Bench bench(one_late_pulse(3));
  bench.burst();
  const struct roll& roll = bench.session.roll;
  ASSERT_EQ(roll.take_count, 2u);
  const size_t edges = roll.takes[0].timeline.count + roll.takes[1].timeline.count;
  ASSERT_EQ(roll_edge_count(&roll), edges);
  size_t replaced = 0, late = 0;
  for (size_t i = 0; i < edges; i++) {
    lamella_v1_TimedEdge edge;
    roll_describe_edge(&roll, i, &edge);
    EXPECT_EQ(edge.shot >= 20, i >= roll.takes[0].timeline.count);
    if (edge.shot >= 20) {
      EXPECT_GT(edge.planned_us, roll.takes[0].plan.duration_us);
    }
    replaced += edge.replaced;
    late += edge.actual_us - edge.planned_us > edge.tolerance_us;
    const bool looped_back =
        std::string(edge.line) == "BLANK" || std::string(edge.line) == "TRIGGER";
    EXPECT_EQ(edge.has_kernel_us, looped_back);
    if (looped_back) {
      EXPECT_NEAR(edge.kernel_us, edge.actual_us, 0.01);
    }
  }
  EXPECT_GT(replaced, 0u);
  EXPECT_EQ(late, 1u);
}

TEST(Retake, ADroppedFrameIsTakenAgain) {
  for (const int shot : {0, 7, 19}) {
    Bench bench(one_dropped_shot(shot));
    const lamella_v1_BurstDone& done = bench.burst();
    EXPECT_FALSE(done.marked) << done.verdict;
    EXPECT_EQ(done.late_edges, 0u);
    EXPECT_EQ(done.frame_count, 40 + 2 * done.retaken - 2);
    EXPECT_NE(std::string(done.verdict).find("dropped by a camera"), std::string::npos)
        << done.verdict;
    EXPECT_EQ(store_find(&bench.photographs, 2 * static_cast<uint32_t>(shot)), nullptr);
    EXPECT_GE(bench.session.roll.shots[shot].replaced_by, 20);
  }
}

TEST(Retake, EveryPlaceEndsWithOneGoodShot) {
  Bench bench(one_late_pulse(6));
  bench.burst();
  for (size_t place = 0; place < 20; place++) {
    EXPECT_FALSE(good_shot_of(bench.session.roll, place).bad) << place;
  }
}

TEST(Retake, AHalfOfAPairComesNoFartherFromItsPartnerThanTheBurstsWidestPair) {
  for (int pulse = 0; pulse < 8; pulse++) {
    Bench bench(one_late_pulse(pulse));
    bench.burst();
    const struct roll& roll = bench.session.roll;
    const burst_plan& plan = roll.takes[0].plan;
    double widest_us = 0;
    for (size_t i = 0; i < plan.count; i++) {
      const size_t partner = burst_partner(plan.steps, plan.count, i);
      if (partner == plan.count) continue;
      widest_us =
          std::fmax(widest_us, std::fabs(plan.times[i].open_us - plan.times[partner].open_us));
    }
    for (size_t i = 0; i < plan.count; i++) {
      const size_t partner = burst_partner(plan.steps, plan.count, i);
      if (partner == plan.count) continue;
      const double apart_us = roll_open_us(&roll, &good_shot_of(roll, i)) -
                              roll_open_us(&roll, &good_shot_of(roll, partner));
      EXPECT_LE(std::fabs(apart_us), widest_us + 1) << "pulse " << pulse << ", step " << i;
    }
  }
}

TEST(Retake, StartsFromWhereTheAnalyserStandsAndMovesItOnlyIfItMust) {
  Bench bench(one_late_pulse(7));  // the last LED light, under the analyser as the burst leaves it
  bench.burst();
  const burst_plan& again = bench.session.roll.takes[1].plan;
  EXPECT_TRUE(again.starts_crossed);
  EXPECT_EQ(again.times[0].analyser_us, 0) << "the first retaken step needs no move";
}

TEST(Retake, WithoutTimeForItTheBurstIsMarkedAndSaysWhy) {
  Bench bench(one_late_pulse(3));
  burst_plan plan;
  burst_order(&bench.rig, kBurstSteps, BURST_STEPS, false, &plan);
  bench.rig.burst_longest_us = plan.duration_us + 20e3;
  const lamella_v1_BurstDone& done = bench.burst();
  EXPECT_TRUE(done.marked);
  EXPECT_EQ(done.retaken, 0u);
  EXPECT_EQ(done.frame_count, 40u);
  EXPECT_NE(std::string(done.verdict).find("not retaken: the burst takes"), std::string::npos)
      << done.verdict;
}

TEST(Retake, ADropThatCannotBeTakenAgainMarksTheBurstAndNamesTheStep) {
  Bench bench(one_dropped_shot(7));
  burst_plan plan;
  burst_order(&bench.rig, kBurstSteps, BURST_STEPS, false, &plan);
  bench.rig.burst_longest_us = plan.duration_us + 20e3;
  const lamella_v1_BurstDone& done = bench.burst();
  EXPECT_TRUE(done.marked);
  EXPECT_EQ(done.frame_count, 38u);
  EXPECT_EQ(std::string(done.verdict).find("MARKED: step 7 dropped by a camera; not retaken: "), 0u)
      << done.verdict;
}

TEST(Retake, CountsTheLightOfTheFirstTakeAgainstDuty) {
  Bench bench(one_late_pulse(7));
  bench.rig.leds_duty_window_us = 3e6;  // the burst's 8 pulses of 30 ms, and no ninth
  bench.rig.leds_highest_duty = 0.0801;
  const lamella_v1_BurstDone& done = bench.burst();
  EXPECT_TRUE(done.marked);
  EXPECT_EQ(done.retaken, 0u);
  EXPECT_NE(std::string(done.verdict).find("highest_duty"), std::string::npos) << done.verdict;
}

TEST(Retake, CountsTheHeatOfTheFirstTake) {
  Bench bench(one_late_pulse(7));
  bench.rig.leds_thermal_time_us = 60e6;  // nothing cools within the burst
  bench.rig.leds_thermal_k_per_w = 1000;
  // Eight pulses of 30 ms: 1500 K x (1 - exp(-0.24 / 60)) = 5.99 K; a ninth brings 6.7 K.
  bench.rig.leds_highest_junction_c = bench.rig.leds_ambient_c + 6.2;
  const lamella_v1_BurstDone& done = bench.burst();
  EXPECT_TRUE(done.marked);
  EXPECT_NE(std::string(done.verdict).find("not retaken: LEDs would reach"), std::string::npos)
      << done.verdict;
}

namespace {

// A burst whose first projector step is dropped, and whose first take has this share of the dose
// of blue light that is allowed.
lamella_v1_BurstDone with_projector_dose(double share) {
  burst_plan plan;
  struct rig rig = test_rig();
  burst_order(&rig, kBurstSteps, BURST_STEPS, false, &plan);
  int shot = 0;
  while (burst_step_is_lit_by_leds(&plan.steps[shot])) shot++;
  Bench bench(one_dropped_shot(shot));
  const double blue = dose_of_projector(&rig, &plan).blue_j_per_m2_sr;
  bench.rig.light_projector_blue_w_per_m2_sr *= share * DOSE_BLUE_LIMIT_J_PER_M2_SR / blue;
  return bench.burst();
}

}  // namespace

TEST(Retake, CountsTheDoseOfTheFirstTake) {
  const lamella_v1_BurstDone within = with_projector_dose(0.6), beyond = with_projector_dose(0.99);
  EXPECT_FALSE(within.marked) << within.verdict;
  EXPECT_TRUE(beyond.marked);
  EXPECT_NE(std::string(beyond.verdict).find("not retaken: blue light"), std::string::npos)
      << beyond.verdict;
}

TEST(Retake, AStepIsTakenAgainOnce) {
  sim_faults faults = kSimNoFaults;
  faults.late_blank_us = 60;  // always
  Bench bench(faults);
  const lamella_v1_BurstDone& done = bench.burst();
  EXPECT_TRUE(done.marked);
  EXPECT_EQ(bench.session.roll.take_count, 2u);
}

TEST(Retake, ABurstLongerThanASubjectSitsStillIsRefused) {
  Bench bench;
  bench.rig.burst_longest_us = 5e5;
  EXPECT_EQ(session_request_burst(&bench.session, false), LAM_UNSAFE);
  EXPECT_NE(std::string(bench.session.refusal).find("burst.longest_us"), std::string::npos);
}
