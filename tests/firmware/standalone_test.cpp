// Button to session with no host, and what light and buzzer say on the way, by their lines alone.
#include <gtest/gtest.h>

#include <cerrno>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "faulty_rig.h"
#include "store_bench.h"

extern "C" {
#include "hal_sim.h"
#include "standalone.h"
}

namespace {

constexpr double kStandaloneTickUs = 10e3;

struct StandaloneBench : FaultyRig {
  explicit StandaloneBench(const std::vector<std::string>& injected = {}) : FaultyRig(injected) {
    session_init(&session, &rig, &sim.hal, &photographs);
    selftest_init(&selftest, &rig, &sim.hal, &photographs);
    standalone_init(&alone, &session, &selftest, SELFTEST_ALL);
    alone.has_button = true;
  }
  ~StandaloneBench() { session_close(&session); }

  double now_us() { return sim.hal.now_us(&sim); }

  // The serving loop without sockets.
  void pass() {
    double due_us = now_us();
    if (session_slack_us(&session) >= 5000) {
      session_watch(&session);
      due_us = standalone_tend(&alone);
    }
    if (!session_work(&session)) sim.hal.wait_until_us(&sim, due_us);
  }
  void run(double for_us) {
    for (const double end_us = now_us() + for_us; now_us() < end_us;) pass();
  }
  void run_until(standalone_state state, double at_most_us = 60e6) {
    const double end_us = now_us() + at_most_us;
    while (alone.state != state && now_us() < end_us) pass();
    ASSERT_EQ(alone.state, state) << kPanelTable[alone.panel.code].name;
  }
  void press(double for_us) {
    sim.faults.press_us = now_us() - sim.opened_us;
    sim.faults.hold_us = for_us;
    run(for_us + 50e3);
  }
  // As a host asks for it, to its end.
  void test(unsigned parts, bool learning = false) {
    const char* why = nullptr;
    ASSERT_EQ(standalone_request_selftest(&alone, parts, learning, &why), LAM_OK) << why;
    while (alone.state == STANDALONE_TESTING) pass();
  }

  // The level of a line at an instant, by what the simulated rig saw.
  bool level(hal_line line, double t_us) const {
    bool level = false;
    for (size_t i = 0; i < sim.signal_count && sim.signals[i].at_us <= t_us; i++) {
      if (sim.signals[i].line == line) level = sim.signals[i].level;
    }
    return level;
  }

  // Asserts that both lines played the code's pattern from its beginning to now.
  void expect_shown(panel_code code) {
    EXPECT_EQ(alone.panel.code, code) << kPanelTable[alone.panel.code].name;
    const panel_entry& entry = kPanelTable[code];
    expect_line(HAL_READY, entry.light, entry.name);
    expect_line(HAL_BUZZER, entry.buzzer, entry.name);
  }

  void expect_line(hal_line line, const panel_pattern& pattern, const char* name) {
    // A tick late at most, and the light as late as it must not rise again.
    const double late_us = 2.5 * kStandaloneTickUs;
    for (double t_us = alone.panel.since_us; t_us < now_us() - late_us; t_us += 1e3) {
      const double since_us = t_us - alone.panel.since_us;
      const bool before = panel_pattern_level(&pattern, since_us - late_us);
      const bool now = panel_pattern_level(&pattern, since_us);
      if (before != now || since_us < late_us) continue;
      ASSERT_EQ(level(line, t_us), now) << name << " line " << line << " at " << since_us;
    }
  }

  struct session session;
  struct selftest selftest;
  struct standalone alone;
};

}  // namespace

TEST(Standalone, ButtonToSessionWithNoHost) {
  StandaloneBench bench;
  EXPECT_EQ(bench.alone.state, STANDALONE_TESTING);
  EXPECT_EQ(bench.alone.panel.code, PANEL_STARTING);
  bench.run_until(STANDALONE_READY);
  bench.run(1e6);
  bench.expect_shown(PANEL_READY);

  bench.press(100e3);
  EXPECT_EQ(bench.alone.state, STANDALONE_COUNTDOWN);
  bench.run(2.5e6);
  bench.expect_shown(PANEL_COUNTDOWN);
  EXPECT_TRUE(bench.twin.reports().size() == 4u) << "no photograph before the countdown is over";

  bench.run_until(STANDALONE_BURST);
  while (bench.session.state != lamella_v1_RigState_RUNNING) bench.pass();
  const double zero_us = bench.session.roll.takes[0].player.zero_us;
  while (bench.session.playing) bench.pass();
  bench.expect_shown(PANEL_BURST);
  for (double t_us = zero_us; t_us < bench.now_us(); t_us += 5e3) {
    ASSERT_FALSE(bench.level(HAL_READY, t_us)) << "the ready light shines into the burst";
    ASSERT_FALSE(bench.level(HAL_BUZZER, t_us));
  }
  bench.run_until(STANDALONE_VERDICT);
  EXPECT_EQ(store_held(&bench.photographs), 40u);
  EXPECT_FALSE(bench.session.done.marked);
  bench.run(2e6);
  bench.expect_shown(PANEL_GOOD);
  bench.run_until(STANDALONE_READY);
}

TEST(Standalone, EveryLastingCodeIsPlayedOnTheLinesAsInTheTable) {
  for (int code = 0; code < PANEL_CODES; code++) {
    StandaloneBench bench;
    bench.run_until(STANDALONE_READY);
    bench.run(1e6);
    panel_show(&bench.alone.panel, PANEL_BURST, bench.now_us());
    bench.run(500e3);  // dark: whatever comes now may rise at once
    panel_show(&bench.alone.panel, static_cast<panel_code>(code), bench.now_us());
    bench.run(12e6);
    bench.expect_shown(static_cast<panel_code>(code));
  }
}

TEST(Standalone, ReadyLightNeverFlashesFasterThanThreeTimesASecond) {
  StandaloneBench bench;
  bench.run_until(STANDALONE_READY);
  for (int i = 0; i < 20; i++) {
    bench.press(60e3);  // into the countdown and out of it again
    bench.run(i * 20e3);
  }
  double last_us = -INFINITY;
  for (size_t i = 0; i < bench.sim.signal_count; i++) {
    const sim_signal& signal = bench.sim.signals[i];
    if (signal.line != HAL_READY || !signal.level) continue;
    EXPECT_GE(signal.at_us - last_us, 1e6 / 3);
    last_us = signal.at_us;
  }
}

TEST(Standalone, ASecondPressCallsTheCountdownOff) {
  StandaloneBench bench;
  bench.run_until(STANDALONE_READY);
  bench.press(100e3);
  bench.run(1e6);
  bench.press(100e3);
  EXPECT_EQ(bench.alone.state, STANDALONE_READY);
  bench.run(5e6);
  EXPECT_EQ(bench.session.burst_id, 0u);
}

TEST(Standalone, AHeldButtonPairsAndDoesNotStartABurst) {
  StandaloneBench bench;
  bench.run_until(STANDALONE_READY);
  bench.sim.faults.press_us = bench.now_us() - bench.sim.opened_us;
  bench.sim.faults.hold_us = 6e6;
  bench.run(5.5e6);
  EXPECT_TRUE(standalone_is_held(&bench.alone));
  bench.expect_shown(PANEL_PAIRING);
  bench.run(1e6);
  EXPECT_FALSE(standalone_is_held(&bench.alone));
  EXPECT_EQ(bench.alone.state, STANDALONE_READY);
  bench.run(5e6);
  EXPECT_EQ(bench.session.burst_id, 0u);
}

TEST(Standalone, AMarkedBurstIsSaidToBeDoubtful) {
  StandaloneBench bench({"late-blank:6000"});
  bench.run_until(STANDALONE_READY);
  bench.press(100e3);
  bench.run_until(STANDALONE_VERDICT);
  bench.run(3e6);
  bench.expect_shown(PANEL_MARKED);
}

TEST(Standalone, EachFaultOfTheSelfTestHasItsCodeAndRefusesTheButton) {
  const std::vector<std::pair<std::string, panel_code>> cases = {
      {"estop", PANEL_FAULT_ESTOP},
      {"hot:95", PANEL_FAULT_HOT},
      {"missing-camera:1", PANEL_FAULT_CAMERA},
      {"stuck-actuator", PANEL_FAULT_ACTUATOR},
      {"missing-chip:3", PANEL_FAULT_LED_CHAIN},
      {"frozen-projector", PANEL_FAULT_PROJECTOR}};
  for (const auto& [fault, code] : cases) {
    StandaloneBench bench({fault});
    bench.run_until(STANDALONE_FAULT);
    bench.run(12e6);
    bench.expect_shown(code);
    bench.press(100e3);  // tests again, finds the same
    bench.run_until(STANDALONE_FAULT);
    bench.run(4e6);
    EXPECT_EQ(bench.alone.panel.code, code) << fault;
    EXPECT_EQ(bench.session.burst_id, 0u) << fault;
  }
}

TEST(Standalone, APartThatFailedStaysFailedUntilATestOfThatPartFindsItGood) {
  const std::vector<std::tuple<std::string, selftest_part, panel_code>> cases = {
      {"slow-actuator:2", SELFTEST_ACTUATOR, PANEL_FAULT_ACTUATOR},
      {"stuck-bit:100", SELFTEST_CHAIN, PANEL_FAULT_LED_CHAIN},
      {"frozen-projector", SELFTEST_PROJECTOR, PANEL_FAULT_PROJECTOR}};
  for (const auto& [fault, part, code] : cases) {
    StandaloneBench bench({fault});
    bench.run_until(STANDALONE_FAULT);
    bench.test(1u << SELFTEST_ESTOP);
    EXPECT_EQ(bench.selftest.bad, 0u) << fault;
    EXPECT_EQ(bench.alone.state, STANDALONE_FAULT) << fault;
    EXPECT_EQ(bench.alone.panel.code, code) << fault;
    bench.press(100e3);  // tests again, the part too, and finds the same
    bench.run_until(STANDALONE_FAULT);
    bench.run(4e6);
    EXPECT_EQ(bench.alone.panel.code, code) << fault;
    EXPECT_EQ(bench.session.burst_id, 0u) << fault;
    bench.sim.faults = kSimNoFaults;
    bench.test(1u << part);
    EXPECT_EQ(bench.alone.state, STANDALONE_READY) << fault;
  }
}

TEST(Standalone, AHostsBurstLeavesAFailedPartFailed) {
  StandaloneBench bench({"slow-actuator:1.2"});
  bench.run_until(STANDALONE_FAULT);
  ASSERT_EQ(session_request_burst(&bench.session, false), LAM_OK) << bench.session.refusal;
  bench.run_until(STANDALONE_VERDICT);
  bench.run(6e6);
  EXPECT_EQ(bench.alone.state, STANDALONE_FAULT);
  EXPECT_EQ(bench.alone.panel.code, PANEL_FAULT_ACTUATOR);
}

TEST(Standalone, AFaultOfABurstThatAHostClearsGivesWayToThePartThatFailedBefore) {
  StandaloneBench bench({"slow-actuator:1.2"});
  bench.run_until(STANDALONE_FAULT);
  ASSERT_EQ(session_request_burst(&bench.session, false), LAM_OK) << bench.session.refusal;
  bench.run_until(STANDALONE_BURST);
  bench.sim.faults.missing_camera = 0;
  bench.run_until(STANDALONE_FAULT);
  EXPECT_EQ(bench.alone.panel.code, PANEL_FAULT_CAMERA);
  bench.test(1u << SELFTEST_ESTOP);
  EXPECT_EQ(bench.alone.panel.code, PANEL_FAULT_CAMERA) << "nobody has cleared it";
  ASSERT_EQ(session_abort(&bench.session), LAM_OK);
  bench.run(100e3);
  EXPECT_EQ(bench.alone.panel.code, PANEL_FAULT_ACTUATOR);
}

TEST(Standalone, TheButtonTestsWhatPowerOnTestsWhateverAHostTestedLast) {
  StandaloneBench bench;
  bench.run_until(STANDALONE_READY);
  bench.test(1u << SELFTEST_ESTOP);
  bench.press(100e3);
  bench.run_until(STANDALONE_BURST);
  bench.sim.faults.missing_camera = 0;
  bench.run_until(STANDALONE_FAULT);
  bench.press(100e3);
  bench.run_until(STANDALONE_FAULT);
  EXPECT_GT(bench.selftest.bad, 0u);
  EXPECT_EQ(bench.alone.panel.code, PANEL_FAULT_CAMERA);
}

// Two LEDs of one chip: their light together is as expected.
TEST(Standalone, WhatAFullTestOfTheLedsFoundIsNotOutdoneByAQuickOne) {
  StandaloneBench bench;
  bench.run_until(STANDALONE_READY);
  bench.test(1u << SELFTEST_LEDS, true);
  size_t other = 18;
  while (bench.rig.leds[other].chip != bench.rig.leds[17].chip) other++;
  const std::string swapped = "swapped-leds:17:" + std::to_string(other);
  ASSERT_TRUE(sim_faults_parse(swapped.c_str(), &bench.sim.faults));
  bench.test(1u << SELFTEST_LEDS);
  ASSERT_EQ(bench.alone.state, STANDALONE_FAULT);
  bench.press(100e3);
  bench.run_until(STANDALONE_FAULT);
  bench.sim.faults = kSimNoFaults;
  bench.press(100e3);
  bench.run_until(STANDALONE_READY);
}

TEST(Standalone, TheButtonIsFeltWhileTheActuatorIsStuck) {
  StandaloneBench bench;
  bench.run_until(STANDALONE_READY);
  bench.sim.faults.stuck_actuator = true;
  bench.press(100e3);
  bench.run_until(STANDALONE_BURST);
  bench.run_until(STANDALONE_FAULT);
  EXPECT_EQ(bench.alone.panel.code, PANEL_FAULT_ACTUATOR);
  bench.run(1e6);
  bench.press(100e3);
  EXPECT_EQ(bench.alone.state, STANDALONE_TESTING);
}

TEST(Standalone, ABurstIsRefusedToAHostTooWhereLightsWouldNotGoOffByThemselves) {
  StandaloneBench bench({"dead-monostable"});
  const char* why = nullptr;
  const char* says =
      "self-test: dark after the last heartbeat: it stays lit when the heart stops: the "
      "monostable, its gate, their wires; mend it, then: lamella rig selftest";
  bench.run_until(STANDALONE_FAULT);
  EXPECT_EQ(session_request_burst(&bench.session, false), LAM_HARDWARE);
  EXPECT_STREQ(bench.session.refusal, says);
  // A later test of something else that is good changes nothing, for the button neither.
  ASSERT_EQ(standalone_request_selftest(&bench.alone, 1u << SELFTEST_CHAIN, false, &why), LAM_OK);
  bench.run_until(STANDALONE_FAULT);
  EXPECT_EQ(bench.selftest.bad, 0u);
  EXPECT_EQ(bench.alone.panel.code, PANEL_FAULT_LED_CHAIN);
  EXPECT_EQ(session_request_burst(&bench.session, false), LAM_HARDWARE);
  bench.sim.faults.dead_monostable = false;
  ASSERT_EQ(standalone_request_selftest(&bench.alone, 1u << SELFTEST_BLANK, false, &why), LAM_OK);
  bench.run_until(STANDALONE_READY);
  EXPECT_EQ(session_request_burst(&bench.session, false), LAM_OK) << bench.session.refusal;
}

TEST(Standalone, ABadReadingOnWhichNoDarknessHangsDoesNotRefuseAHost) {
  StandaloneBench bench({"missing-chip:3"});
  bench.run_until(STANDALONE_FAULT);
  EXPECT_EQ(session_request_burst(&bench.session, false), LAM_OK) << bench.session.refusal;
}

TEST(Standalone, AProjectorWhoseFlipsDoNotHappenIsToldWithWhatToDo) {
  StandaloneBench bench({"frozen-projector"});
  const struct hal_pattern pattern = {};
  double at_us = 0;
  ASSERT_EQ(bench.sim.hal.commit_pattern(&bench.sim, pattern, &at_us), LAM_OK);
  EXPECT_EQ(bench.sim.hal.commit_pattern(&bench.sim, pattern, &at_us), LAM_HARDWARE);
  EXPECT_STREQ(bench.sim.hal.error,
               "a flip was committed before the last one happened: is the projector on and plugged "
               "in?");
}

TEST(Standalone, AnEmergencyStopWhileReadyIsShownAndRecoveredFrom) {
  StandaloneBench bench;
  bench.run_until(STANDALONE_READY);
  bench.press(100e3);
  bench.sim.faults.estopped = true;
  bench.run(1e6);
  EXPECT_EQ(bench.alone.panel.code, PANEL_FAULT_ESTOP);
  bench.run(5e6);
  EXPECT_EQ(bench.session.burst_id, 0u) << "the countdown went on";
  bench.sim.faults.estopped = false;
  bench.run(1e6);
  EXPECT_EQ(bench.alone.state, STANDALONE_FAULT) << "nobody has looked yet";
  bench.press(100e3);
  bench.run_until(STANDALONE_READY);
}

TEST(Standalone, AnEmergencyStopThatWasSeenStandsUntilItIsTested) {
  StandaloneBench bench;
  bench.run_until(STANDALONE_READY);
  bench.sim.faults.estopped = true;
  bench.run(1e6);
  bench.sim.faults.estopped = false;
  bench.test(1u << SELFTEST_CHAIN);
  EXPECT_EQ(bench.alone.panel.code, PANEL_FAULT_ESTOP);
  bench.test(1u << SELFTEST_ESTOP);
  EXPECT_EQ(bench.alone.state, STANDALONE_READY);
  ASSERT_EQ(session_request_burst(&bench.session, false), LAM_OK);
  bench.run_until(STANDALONE_BURST);
  bench.sim.faults.estopped = true;
  bench.run_until(STANDALONE_FAULT);
  bench.sim.faults.estopped = false;
  ASSERT_EQ(session_abort(&bench.session), LAM_OK);
  bench.test(1u << SELFTEST_CHAIN);
  EXPECT_EQ(bench.alone.panel.code, PANEL_FAULT_ESTOP) << "a burst saw it";
}

TEST(Standalone, AFaultOfTheBurstIsShownAndClearedByTheButton) {
  StandaloneBench bench;
  bench.run_until(STANDALONE_READY);
  bench.press(100e3);
  bench.run_until(STANDALONE_BURST);
  bench.sim.faults.missing_camera = 0;
  bench.run_until(STANDALONE_FAULT);
  EXPECT_EQ(bench.alone.panel.code, PANEL_FAULT_CAMERA);
  bench.sim.faults.missing_camera = -1;
  bench.press(100e3);
  bench.run_until(STANDALONE_READY);
  EXPECT_EQ(bench.session.state, lamella_v1_RigState_IDLE);
}

TEST(Standalone, PhotographsThatNobodyFetchedAreNotOverwritten) {
  StandaloneBench bench;
  bench.run_until(STANDALONE_READY);
  bench.press(100e3);
  bench.run_until(STANDALONE_VERDICT);
  bench.run_until(STANDALONE_READY);
  bench.press(100e3);
  bench.run_until(STANDALONE_VERDICT);
  bench.run(3e6);
  bench.expect_shown(PANEL_REFUSED_FULL);
  EXPECT_EQ(store_held(&bench.photographs), 40u);
}

TEST(Standalone, ADiskThatDoesNotTakeABurstIsShownAsAFaultOfTheDiskAndNotAsFull) {
  const TemporaryFolder folder;
  StandaloneBench bench;
  char why[160];
  ASSERT_EQ(store_open(&bench.photographs, folder.path().c_str(), nullptr, 0, why, sizeof why),
            LAM_OK);
  bench.run_until(STANDALONE_READY);
  bench.photographs.disk.before = [](void*, const disk_step*) { return EROFS; };
  bench.press(100e3);
  bench.run_until(STANDALONE_VERDICT);
  bench.run(3e6);
  bench.expect_shown(PANEL_FAULT_DISK);
  store_close(&bench.photographs);
}

TEST(Standalone, AnUnsafePlanIsRefused) {
  StandaloneBench bench;
  bench.run_until(STANDALONE_READY);
  bench.rig.leds_light_us = 30400;
  bench.press(100e3);
  bench.run_until(STANDALONE_VERDICT);
  bench.run(3e6);
  bench.expect_shown(PANEL_REFUSED_UNSAFE);
}

TEST(Standalone, WhoAskedFirstHasTheRig) {
  StandaloneBench bench;
  EXPECT_EQ(session_request_burst(&bench.session, false), LAM_WRONG_STATE) << "it tests itself";
  bench.run_until(STANDALONE_READY);
  bench.press(100e3);
  EXPECT_EQ(session_request_burst(&bench.session, false), LAM_WRONG_STATE) << "it counts down";
  EXPECT_NE(std::string(bench.session.refusal).find("counts down"), std::string::npos);
  const char* why = nullptr;
  EXPECT_EQ(standalone_request_selftest(&bench.alone, SELFTEST_ALL, false, &why), LAM_WRONG_STATE);
  bench.press(100e3);
  EXPECT_EQ(session_request_burst(&bench.session, false), LAM_OK);
  bench.run(60e3);
  EXPECT_EQ(bench.alone.state, STANDALONE_BURST) << "a host's burst is shown as well";
  bench.run_until(STANDALONE_VERDICT);
  EXPECT_EQ(bench.alone.panel.code, PANEL_GOOD);
}

TEST(Standalone, WithoutTheOptionTheButtonStartsNothing) {
  StandaloneBench bench;
  bench.alone.has_button = false;
  bench.run_until(STANDALONE_READY);
  bench.press(100e3);
  bench.run(3e6);
  bench.expect_shown(PANEL_REFUSED_BUSY);
}

TEST(Standalone, ASelfTestOnRequestEndsReady) {
  StandaloneBench bench;
  bench.run_until(STANDALONE_READY);
  const char* why = nullptr;
  ASSERT_EQ(standalone_request_selftest(&bench.alone, 1u << SELFTEST_LEDS, true, &why), LAM_OK);
  bench.run_until(STANDALONE_TESTING);
  bench.run_until(STANDALONE_READY);
  EXPECT_EQ(bench.selftest.reference.led_count, bench.rig.led_count);
}
