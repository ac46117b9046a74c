#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "test_rig.h"

extern "C" {
#include "burst.h"
#include "safety.h"
#include "timeline.h"
}

namespace {

// The paper's burst, timed and laid out, to be spoiled by the test.
class Safety : public ::testing::Test {
 protected:
  void SetUp() override { lay_out(); }

  void lay_out() {
    burst_order(&rig, kBurstSteps, BURST_STEPS, false, &plan);
    timeline_build(&rig, &plan, &timeline);
  }

  edge& find(enum edge_line line, int value, int nth = 0) {
    for (size_t i = 0; i < timeline.count; i++) {
      edge& e = timeline.edges[i];
      if (e.line == line && e.value == value && nth-- == 0) return e;
    }
    ADD_FAILURE() << timeline_line_name(line) << " " << value;
    return timeline.edges[0];
  }

  void sort() {
    std::stable_sort(timeline.edges, timeline.edges + timeline.count,
                     [](const edge& a, const edge& b) { return a.t_us < b.t_us; });
  }

  void remove(const edge& gone) {
    const size_t at = static_cast<size_t>(&gone - timeline.edges);
    std::copy(timeline.edges + at + 1, timeline.edges + timeline.count, timeline.edges + at);
    timeline.count--;
  }

  void expect_broken(safety_rule rule) {
    sort();
    safety_finding finding;
    ASSERT_EQ(safety_check(&rig, &timeline, &finding), LAM_UNSAFE);
    EXPECT_EQ(finding.rule, rule) << finding.text;
  }

  size_t projector_step() const {
    for (size_t i = 0; i < plan.count; i++) {
      if (!burst_step_is_lit_by_leds(&plan.steps[i])) return i;
    }
    return 0;
  }

  edge& of_step(size_t step, enum edge_line line, int value) {
    for (size_t i = 0; i < timeline.count; i++) {
      edge& e = timeline.edges[i];
      if (e.step == step && e.line == line && e.value == value) return e;
    }
    ADD_FAILURE() << step << " " << timeline_line_name(line);
    return timeline.edges[0];
  }

  struct rig rig = test_rig();
  burst_plan plan;
  struct timeline timeline;
};

}  // namespace

TEST_F(Safety, PassesTheBurstFromEitherSide) {
  for (const bool crossed : {false, true}) {
    burst_order(&rig, kBurstSteps, BURST_STEPS, crossed, &plan);
    timeline_build(&rig, &plan, &timeline);
    safety_finding finding;
    EXPECT_EQ(safety_check(&rig, &timeline, &finding), LAM_OK) << finding.text;
  }
}

TEST_F(Safety, PassesBurstsOfRigsWithOtherNumbers) {
  const struct rig first = rig;
  for (const double scale : {0.25, 0.5, 2.0, 7.0}) {
    for (double rig::*number :
         {&rig::camera_readout_us, &rig::camera_start_delay_us, &rig::camera_guard_us,
          &rig::analyser_move_us, &rig::analyser_settle_us, &rig::projector_refresh_hz,
          &rig::projector_latency_us, &rig::projector_settle_us, &rig::projector_commit_lead_us,
          &rig::projector_lamp_settle_us, &rig::burst_pair_weight}) {
      rig = first;
      rig.*number *= scale;
      lay_out();
      safety_finding finding;
      EXPECT_EQ(safety_check(&rig, &timeline, &finding), LAM_OK)
          << finding.text << ", numbers scaled by " << scale;
    }
  }
}

TEST_F(Safety, RefusesLightLongerThanTheLongestOnTime) {
  rig.leds_light_us = 41000;
  lay_out();
  expect_broken(SAFETY_LED_ON_TIME);
}

TEST_F(Safety, RefusesMoreDutyThanAllowed) {
  rig.leds_highest_duty = 0.2;  // eight pulses of 30 ms within a second are 0.24
  lay_out();
  expect_broken(SAFETY_LED_DUTY);
}

TEST_F(Safety, RefusesLightThatIsNotWholePwmPeriods) {
  rig.leds_light_us = 30400;
  lay_out();
  expect_broken(SAFETY_PWM_PERIODS);
}

TEST_F(Safety, RefusesShiftingWhileLedsAreLit) {
  find(EDGE_SHIFT, 0, 1).t_us = find(EDGE_BLANK, 0).t_us + 10;
  expect_broken(SAFETY_CHAIN_DARK);
}

TEST_F(Safety, RefusesLatchBeforeTheLastBitIsIn) {
  find(EDGE_LATCH, 1).t_us = find(EDGE_SHIFT, 0).t_us + rig_shift_us(&rig) / 2;
  expect_broken(SAFETY_CHAIN_DARK);
}

TEST_F(Safety, RefusesLightBeforeTheExposureOpens) {
  find(EDGE_BLANK, 0, 1).t_us -= rig.camera_guard_us + 1000;
  expect_broken(SAFETY_LIGHT_INSIDE);
}

TEST_F(Safety, RefusesLightThatOutlastsTheExposure) {
  find(EDGE_TRIGGER, 0).t_us -= 1000;
  expect_broken(SAFETY_LIGHT_INSIDE);
}

TEST_F(Safety, RefusesAnExposureDuringReadout) {
  find(EDGE_TRIGGER, 1, 1).t_us -= 100;
  expect_broken(SAFETY_READOUT);
}

TEST_F(Safety, RefusesAnExposureBeforeTheAnalyserHasSettled) {
  edge& start = find(EDGE_ANALYSER, 1);
  find(EDGE_ARRIVED, 1).t_us += 1000;
  start.t_us += 1000;
  expect_broken(SAFETY_ANALYSER);
}

TEST_F(Safety, RefusesASecondMove) {
  edge& arrived = find(EDGE_ARRIVED, 1);
  arrived.line = EDGE_ANALYSER;
  arrived.t_us = find(EDGE_ANALYSER, 1).t_us + 1;
  expect_broken(SAFETY_ANALYSER);
}

TEST_F(Safety, RefusesAProjectorExposureOfBrokenRefreshPeriods) {
  of_step(plan.count - 1, EDGE_TRIGGER, 0).t_us -= 500;
  expect_broken(SAFETY_REFRESH);
}

TEST_F(Safety, RefusesAnExposureBeforeThePatternIsStable) {
  edge& vblank = of_step(projector_step(), EDGE_VBLANK, 1);
  vblank.t_us += rig_refresh_us(&rig);
  expect_broken(SAFETY_REFRESH);
}

TEST_F(Safety, RefusesAFlipWhoseLightComesIntoTheExposureBefore) {
  const size_t last = plan.count - 1;  // projector steps end the burst
  of_step(last, EDGE_COMMIT, 0).t_us -= rig_refresh_us(&rig);
  of_step(last, EDGE_VBLANK, 1).t_us -= rig_refresh_us(&rig);
  expect_broken(SAFETY_REFRESH);
}

TEST_F(Safety, RefusesLedLightWhileTheLampIsOn) {
  remove(find(EDGE_LAMP, 0));
  expect_broken(SAFETY_ONE_LIGHT);
}

TEST_F(Safety, RefusesAnExposureThatNothingLights) {
  remove(find(EDGE_LAMP, 1));
  expect_broken(SAFETY_ONE_LIGHT);
}

TEST_F(Safety, RefusesABurstThatLeavesALightOn) {
  remove(timeline.edges[timeline.count - 1]);
  expect_broken(SAFETY_ORDER);
}

TEST_F(Safety, RefusesEdgesOutOfOrder) {
  std::swap(timeline.edges[3].t_us, timeline.edges[9].t_us);
  safety_finding finding;
  ASSERT_EQ(safety_check(&rig, &timeline, &finding), LAM_UNSAFE);
  EXPECT_EQ(finding.rule, SAFETY_ORDER);
}

TEST_F(Safety, FindingNamesTheEdge) {
  find(EDGE_BLANK, 0, 1).t_us -= rig.camera_guard_us + 1000;
  sort();
  safety_finding finding;
  safety_check(&rig, &timeline, &finding);
  EXPECT_EQ(timeline.edges[finding.edge].line, EDGE_BLANK);
  EXPECT_EQ(std::string(finding.text).find("edge " + std::to_string(finding.edge)), 0u);
}

TEST_F(Safety, TimelineHoldsEveryEdgeInOrderOfTime) {
  EXPECT_TRUE(std::is_sorted(timeline.edges, timeline.edges + timeline.count,
                             [](const edge& a, const edge& b) { return a.t_us < b.t_us; }));
  const auto count = [&](enum edge_line line) {
    return std::count_if(timeline.edges, timeline.edges + timeline.count,
                         [&](const edge& e) { return e.line == line; });
  };
  EXPECT_EQ(count(EDGE_TRIGGER), 40);
  EXPECT_EQ(count(EDGE_BLANK), 16);
  EXPECT_EQ(count(EDGE_SHIFT), 8);
  EXPECT_EQ(count(EDGE_VBLANK), 12);
  EXPECT_EQ(count(EDGE_ANALYSER), 1);
}

TEST_F(Safety, FlipsArePipelinedToTheFirstVblankWhoseLightComesAfterTheExposure) {
  for (size_t i = 1; i < plan.count; i++) {
    if (burst_step_is_lit_by_leds(&plan.steps[i])) continue;
    const double slack_us =
        plan.times[i].vblank_us + rig.projector_latency_us - plan.times[i - 1].close_us;
    EXPECT_GE(slack_us, -1e-3);
    EXPECT_LT(slack_us, rig_refresh_us(&rig));
  }
}
