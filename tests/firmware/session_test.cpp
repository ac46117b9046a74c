#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "session_bench.h"

namespace {

constexpr auto kFull = lamella_v1_Frame_Role_GRADIENT_FULL;
constexpr auto kX = lamella_v1_Frame_Role_GRADIENT_X;
constexpr auto kFront = lamella_v1_Frame_Role_FRONT;
constexpr double kDn = 1 / kFakeWhiteDn;

}  // namespace

TEST(Session, TakesFortyPhotographsAndMarksNone) {
  Bench bench;
  const lamella_v1_BurstDone& done = bench.burst();
  EXPECT_EQ(done.frame_count, 40u);
  EXPECT_FALSE(done.marked) << done.verdict;
  EXPECT_EQ(bench.session.state, lamella_v1_RigState_IDLE);
  EXPECT_EQ(store_held(&bench.photographs), 40u);
}

TEST(Session, LightOfEveryExposureIsLevelTimesOnTime) {
  Bench bench;
  bench.burst();
  const std::vector<double> parallel = bench.picture(kX, false);
  const std::vector<double> crossed = bench.picture(kX, true);
  for (size_t i = 0; i < bench.rig.led_count; i++) {
    const double level = (1 + bench.rig.leds[i].direction[0]) / 2;
    EXPECT_NEAR(parallel[i], level * 0.75, 2 * kDn) << i;  // S + D/2
    EXPECT_NEAR(crossed[i], level * 0.25, 2 * kDn) << i;   // D/2
  }
  EXPECT_NEAR(parallel.back(), 0, kDn);  // no projector light in an LED exposure
}

TEST(Session, ProjectorExposuresHoldOnePatternForWholeRefreshes) {
  Bench bench;
  bench.burst();
  int projector = 0;
  for (const lamella_v1_ExposureReport& report : bench.twin.reports()) {
    if (report.leds_count > 0) continue;
    projector++;
    ASSERT_EQ(report.patterns_count, 1);
    EXPECT_NEAR(report.patterns[0].off_us - report.patterns[0].on_us, report.projector_reference_us,
                1e-3);
  }
  EXPECT_EQ(projector, 24);
  EXPECT_NEAR(bench.picture(kFront, false).back(), 0.75, kDn);
  EXPECT_NEAR(bench.picture(kFront, true).back(), 0.25, kDn);
}

TEST(Session, RightCameraIsAlwaysCrossed) {
  Bench bench;
  bench.burst();
  for (const lamella_v1_ExposureReport& report : bench.twin.reports()) {
    EXPECT_EQ(report.camera == 1, report.analyser_count == 0);
  }
  for (size_t i = 1; i < bench.photographs.count; i += 2) {
    const lamella_v1_Frame& frame = bench.photographs.photographs[i].frame;
    EXPECT_STREQ(frame.camera, "right");
    EXPECT_EQ(frame.analyser, lamella_v1_Frame_Analyser_CROSS);
  }
}

TEST(Session, FramesCarryTheTimesAtWhichTheirLightReallyCame) {
  Bench bench;
  bench.burst();
  for (size_t i = 0; i < bench.photographs.count; i++) {
    const lamella_v1_Frame& frame = bench.photographs.photographs[i].frame;
    const bool leds = frame.role <= lamella_v1_Frame_Role_GRADIENT_Z;
    EXPECT_NEAR(frame.light_off_us - frame.light_on_us, leds ? 30000 : 33333.33, 0.01);
    EXPECT_NEAR(frame.exposure_us, leds ? 30600 : 33333.33, 0.01);
    EXPECT_GE(frame.light_on_us, frame.trigger_us);
  }
}

TEST(Session, FlippedSpiBitGivesAWrongPicture) {
  sim_faults faults = kSimNoFaults;
  // The top bit of LED 0: chip 0 output 0, so the last code of the stream.
  faults.flipped_bit = CHAIN_BITS - 12;
  Bench bench(faults);
  // A driver that tells of nothing but levels; the other kind finds it before the burst.
  bench.rig.leds_have_functions = bench.sim.light.chain.has_functions = false;
  EXPECT_FALSE(bench.burst().marked);  // no edge was late: only the picture knows
  const std::vector<double> wrong = bench.picture(kFull, false);
  EXPECT_NEAR(wrong[0], 0.75 * (4095 - 2048) / 4095, 2 * kDn);
  EXPECT_NEAR(wrong[1], 0.75, 2 * kDn);
}

TEST(Session, ADriverThatDoesNotKeepItsFunctionsIsFoundBeforeAnythingIsPhotographed) {
  for (const char* fault : {"forgetful-chip:3", "flip-bit:2004"}) {
    sim_faults faults = kSimNoFaults;
    ASSERT_TRUE(sim_faults_parse(fault, &faults));
    Bench bench(faults);
    bench.burst();
    EXPECT_EQ(bench.session.state, lamella_v1_RigState_FAULT) << fault;
    EXPECT_EQ(bench.session.fault_part, LAM_PART_LED_CHAIN) << fault;
    EXPECT_NE(std::string(bench.session.fault).find("does not keep its functions"),
              std::string::npos)
        << bench.session.fault;
    EXPECT_EQ(bench.photographs.count, 0u);
  }
}

TEST(Session, LateBlankGivesADarkerPictureAndMarksTheBurst) {
  sim_faults faults = kSimNoFaults;
  faults.late_blank_us = 6000;
  Bench bench(faults);
  const lamella_v1_BurstDone& done = bench.burst();
  EXPECT_NEAR(bench.picture(kFull, false)[5], 0.75 * 24 / 30, 2 * kDn);
  EXPECT_TRUE(done.marked);
  EXPECT_EQ(done.late_edges, 16u);  // those of the retakes too, which were no better
  EXPECT_EQ(done.retaken, 8u);
  EXPECT_NE(std::string(done.verdict).find("BLANK of step 0 by 6000 us"), std::string::npos)
      << done.verdict;
  for (size_t i = 0; i < bench.photographs.count; i++) {
    const struct photograph& p = bench.photographs.photographs[i];
    EXPECT_EQ(p.marked, p.frame.role <= lamella_v1_Frame_Role_GRADIENT_Z);
  }
}

TEST(Session, LateBlankOfAPartOfAPwmPeriodBreaksTheLevels) {
  sim_faults faults = kSimNoFaults;
  faults.late_blank_us = 500;  // 29.5 periods: dim LEDs keep their pulse, bright ones lose half one
  Bench bench(faults);
  bench.burst();
  const std::vector<double> wrong = bench.picture(kX, false);
  for (size_t i = 0; i < bench.rig.led_count; i++) {
    const double level = (1 + bench.rig.leds[i].direction[0]) / 2;
    const double expected = (29 * level + std::fmin(level, 0.5)) / 30;
    EXPECT_NEAR(wrong[i], expected * 0.75, 3 * kDn) << level;
  }
}

TEST(Session, AnalyserStillMovingGivesAWrongPictureAndMarksTheFrames) {
  sim_faults faults = kSimNoFaults;
  faults.slow_actuator = 2;
  Bench bench(faults);
  const lamella_v1_BurstDone& done = bench.burst();
  EXPECT_TRUE(done.marked);
  // The first crossed exposure sees S that a crossed analyser would have stopped.
  size_t first = 0;
  while (!session_plan(&bench.session)->steps[first].crossed) first++;
  const struct photograph& spoiled = bench.photographs.photographs[2 * first];
  EXPECT_TRUE(spoiled.marked);
  EXPECT_GT(unpack_first_row(spoiled.bytes)[3], 0.25 * 4095 / 4095 * 0.5 + 5 * kDn);
  EXPECT_FALSE(bench.photographs.photographs[0].marked);
  EXPECT_FALSE(bench.photographs.photographs[39].marked);
}

TEST(Session, SecondBurstStartsWhereTheAnalyserStands) {
  Bench bench;
  bench.burst();
  EXPECT_FALSE(session_plan(&bench.session)->starts_crossed);
  bench.burst();
  EXPECT_TRUE(session_plan(&bench.session)->starts_crossed);
  EXPECT_NEAR(bench.picture(kFull, false)[5], 0.75, 2 * kDn);
  EXPECT_NEAR(bench.picture(kFull, true)[5], 0.25, 2 * kDn);
  EXPECT_EQ(bench.session.burst_id, 2u);
}

// A busy machine may be late; what must hold on any machine is that it says so.
TEST(Session, OnTheRealClockRecordsWhatReallyHappened) {
  Bench bench(kSimNoFaults, FakeTwin::Mood::kHonest, SIM_CLOCK_REAL);
  const auto begin = std::chrono::steady_clock::now();
  bench.burst();
  const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - begin;
  const struct take& take = bench.session.roll.takes[0];
  const struct player& player = take.player;
  const edge& last = take.timeline.edges[take.timeline.count - 1];
  if (player_is_done(&player)) {
    EXPECT_GT(took.count(), last.t_us);
  }
  size_t late = 0;
  for (size_t i = 0; i < take.timeline.count; i++) {
    const edge& e = take.timeline.edges[i];
    if (!player.played[i].done) continue;  // the burst ended in a fault before
    EXPECT_GE(player.played[i].actual_us, e.t_us - 1);
    late += player.played[i].actual_us - e.t_us > e.tolerance_us;
  }
  EXPECT_EQ(player.late_count, late);
  if (bench.session.state == lamella_v1_RigState_FAULT) {
    EXPECT_GT(late, 0u) << bench.session.fault;
  } else {
    EXPECT_EQ(bench.session.done.marked || bench.session.done.retaken > 0, late > 0);
  }
}

TEST(SessionStates, OnlyTheDrawnTransitionsAreLegal) {
  const lamella_v1_RigState idle = lamella_v1_RigState_IDLE, armed = lamella_v1_RigState_ARMED,
                            running = lamella_v1_RigState_RUNNING,
                            fault = lamella_v1_RigState_FAULT;
  const std::vector<std::pair<lamella_v1_RigState, lamella_v1_RigState>> legal = {
      {idle, armed},   {armed, running}, {armed, idle}, {armed, fault},
      {running, idle}, {running, fault}, {fault, idle}};
  for (const auto from : {idle, armed, running, fault}) {
    for (const auto to : {idle, armed, running, fault}) {
      const bool is_legal =
          std::find(legal.begin(), legal.end(), std::pair(from, to)) != legal.end();
      EXPECT_EQ(session_may_go(from, to), is_legal) << from << " to " << to;
    }
  }
}

TEST(SessionStates, ABurstIsRefusedWhileOneIsUnderWay) {
  Bench bench;
  ASSERT_EQ(session_request_burst(&bench.session, false), LAM_OK);
  EXPECT_EQ(session_request_burst(&bench.session, false), LAM_WRONG_STATE);
  session_work(&bench.session);
  EXPECT_EQ(bench.session.state, lamella_v1_RigState_RUNNING);
  EXPECT_EQ(session_request_burst(&bench.session, true), LAM_WRONG_STATE);
}

TEST(SessionStates, AbortTurnsTheLightsOffAndDropsTheBurst) {
  Bench bench;
  ASSERT_EQ(session_request_burst(&bench.session, false), LAM_OK);
  while (bench.sim.light.blank) session_work(&bench.session);  // until LEDs are lit
  EXPECT_EQ(session_abort(&bench.session), LAM_OK);
  EXPECT_TRUE(bench.sim.light.blank);
  EXPECT_EQ(bench.session.state, lamella_v1_RigState_IDLE);
  EXPECT_FALSE(session_work(&bench.session));
  EXPECT_EQ(bench.burst().frame_count, 40u);
}

TEST(SessionStates, ThereIsNothingToAbortWhileIdle) {
  Bench bench;
  EXPECT_EQ(session_abort(&bench.session), LAM_WRONG_STATE);
}

TEST(SessionStates, PhotographsHeldAreNotOverwrittenUnasked) {
  Bench bench;
  bench.burst();
  EXPECT_EQ(session_request_burst(&bench.session, false), LAM_WRONG_STATE);
  EXPECT_NE(std::string(bench.session.refusal).find("held"), std::string::npos);
  EXPECT_EQ(store_held(&bench.photographs), 40u);
  for (size_t i = 0; i < 40; i++) bench.photographs.photographs[i].acknowledged = true;
  EXPECT_EQ(session_request_burst(&bench.session, false), LAM_OK);
}

TEST(SessionStates, AnUnsafePlanMovesNothing) {
  Bench bench;
  bench.rig.leds_light_us = 30400;
  EXPECT_EQ(session_request_burst(&bench.session, false), LAM_UNSAFE);
  EXPECT_NE(std::string(bench.session.refusal).find("PWM"), std::string::npos);
  EXPECT_EQ(bench.session.state, lamella_v1_RigState_IDLE);
}

TEST(SessionFaults, TwinsWordsReachTheOperatorAndAbortClearsTheFault) {
  Bench bench(kSimNoFaults, FakeTwin::Mood::kSaysError);
  ASSERT_EQ(session_request_burst(&bench.session, false), LAM_OK);
  while (session_work(&bench.session)) continue;
  EXPECT_EQ(bench.session.state, lamella_v1_RigState_FAULT);
  EXPECT_STREQ(bench.session.fault, "the twin says: the subject has left");
  EXPECT_EQ(session_request_burst(&bench.session, false), LAM_WRONG_STATE);
  EXPECT_EQ(session_abort(&bench.session), LAM_OK);
  EXPECT_EQ(bench.session.state, lamella_v1_RigState_IDLE);
}

TEST(SessionFaults, BrokenDamagedAndOversizedPhotographsAreFaults) {
  const std::vector<std::pair<FakeTwin::Mood, std::string>> cases = {
      {FakeTwin::Mood::kHangsUpMidway, "in the middle of a photograph"},
      {FakeTwin::Mood::kDamagesBytes, "does not match its checksum"},
      {FakeTwin::Mood::kIsTooLarge, "raise store.capacity_bytes"}};
  for (const auto& [mood, says] : cases) {
    Bench bench(kSimNoFaults, mood);
    ASSERT_EQ(session_request_burst(&bench.session, false), LAM_OK);
    while (session_work(&bench.session)) continue;
    EXPECT_EQ(bench.session.state, lamella_v1_RigState_FAULT);
    EXPECT_NE(std::string(bench.session.fault).find(says), std::string::npos)
        << bench.session.fault;
    EXPECT_EQ(bench.photographs.count, 0u);
  }
}

TEST(SimulatedRig, WithoutATwinSaysSo) {
  const struct rig rig = test_rig();
  struct hal_sim sim;
  EXPECT_EQ(hal_sim_open(&sim, &rig, SIM_CLOCK_VIRTUAL, kSimNoFaults, "/nowhere/socket"),
            LAM_HARDWARE);
  EXPECT_NE(std::string(sim.hal.error).find("no twin answers"), std::string::npos);
}

TEST(SimulatedRig, CameraMissesATriggerDuringReadout) {
  Bench bench;
  struct hal& hal = bench.sim.hal;
  double zero_us = 0, at_us = 0;
  hal.prepare(hal.self, &zero_us);
  for (const double t_us : {0.0, 10000.0, 12000.0, 20000.0}) {
    hal.wait_until_us(hal.self, zero_us + t_us);
    hal.set_line(hal.self, HAL_TRIGGER, t_us == 0 || t_us == 12000, &at_us);
  }
  uint8_t room[4096];
  hal_photograph photograph = {room, sizeof room, {}, {}};
  EXPECT_EQ(hal.read_photograph(hal.self, 0, 0, &photograph), LAM_OK);
  EXPECT_EQ(hal.read_photograph(hal.self, 1, 0, &photograph), LAM_DROPPED);
  EXPECT_NE(std::string(photograph.error).find("missed a trigger"), std::string::npos);
}

TEST(SimulatedRig, LatchingLitLedsChangesTheLightAtOnce) {
  Bench bench;
  sim_light& light = bench.sim.light;
  uint8_t stream[CHAIN_BYTES] = {};
  uint16_t codes[RIG_MAX_LEDS] = {};
  codes[0] = 2048;
  led_chain_encode(&bench.rig, codes, stream);
  light.chain.has_functions = false;
  memset(light.chain.latched, 0, sizeof light.chain.latched);
  sim_light_blank(&light, false, 1000);
  sim_chain_shift(&light.chain, stream, CHAIN_BITS, nullptr);
  sim_light_latch(&light, true, 3000);
  sim_light_blank(&light, true, 6000);
  lamella_v1_ExposureReport report;
  ASSERT_TRUE(sim_light_report(&light, 0, 0, 10000, &report));
  ASSERT_EQ(report.leds_count, 2);
  EXPECT_EQ(report.leds[0].codes.bytes[1], 0);
  EXPECT_EQ(report.leds[1].codes.bytes[1], 2048 >> 8);
  EXPECT_DOUBLE_EQ(report.leds[1].on_us, 3000);
}

TEST(SimulatedRig, TurningAnalyserIsReportedAsItTurned) {
  Bench bench;
  sim_light_move(&bench.sim.light, M_PI_2, 1000, 2000);
  lamella_v1_ExposureReport report;
  ASSERT_TRUE(sim_light_report(&bench.sim.light, 0, 1500, 3000, &report));
  ASSERT_EQ(report.analyser_count, 2);
  EXPECT_NEAR(report.analyser[0].from_rad, M_PI_4, 1e-12);
  EXPECT_NEAR(report.analyser[0].to_rad, M_PI_2, 1e-12);
  EXPECT_DOUBLE_EQ(report.analyser[0].to_us, 2000);
  EXPECT_DOUBLE_EQ(report.analyser[1].from_rad, report.analyser[1].to_rad);
}
