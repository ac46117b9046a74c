// Every cause that ends a burst puts the lights out within 10 ms. The rig is in memory; its clock
// is moved on as the serving loop (link.c) sleeps on a real one: in rests between edges, watching.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "fake_twin.h"
#include "test_rig.h"

extern "C" {
#include "hal_sim.h"
#include "session.h"
#include "store_inside.h"
}

namespace {

constexpr double kLimitUs = 10000;
constexpr double kRestUs = 2000, kReadyUs = 1000;  // link.c's

class Stage {
 public:
  explicit Stage(const std::vector<std::string>& faults = {}) : block_(4 << 20) {
    sim_faults injected = kSimNoFaults;
    for (const std::string& fault : faults) {
      EXPECT_TRUE(sim_faults_parse(fault.c_str(), &injected)) << fault;
    }
    EXPECT_EQ(hal_sim_open(&sim, &rig, SIM_CLOCK_VIRTUAL, injected, twin_.path().c_str()), LAM_OK);
    store_init(&store, block_.data(), block_.size());
    session_init(&session, &rig, &sim.hal, &store);
    EXPECT_EQ(session_request_burst(&session, true), LAM_OK) << session.refusal;
  }
  ~Stage() {
    session_close(&session);
    sim.hal.close(&sim);
  }

  double now_us() { return sim.hal.now_us(&sim); }
  // The clock goes on and nobody watches: the sequencer does not get the processor.
  void stall(double us) { sim.hal.wait_until_us(&sim, now_us() + us); }
  bool is_lit() const {
    const bool lamp = sim.light.lamp_count > 0 && sim.light.lamps[sim.light.lamp_count - 1].on;
    return !sim.light.blank || lamp;
  }
  bool is_under_way() const {
    return session.state == lamella_v1_RigState_ARMED || session.playing;
  }

  // One turn of the serving loop.
  void turn() {
    const double slack_us = session_slack_us(&session);
    if (session.playing && slack_us > kReadyUs) {
      stall(std::min(slack_us - kReadyUs, kRestUs));
      session_watch(&session);
    } else {
      session_work(&session);
    }
  }
  // Turns until `when`, with edges still to be played.
  void play_until(const std::function<bool()>& when) {
    while (is_under_way() && !when()) turn();
    ASSERT_TRUE(is_under_way()) << session.fault;
  }
  void play_until_lit_by_leds() {
    play_until([this] { return !sim.light.blank; });
    play_until([this, from_us = now_us()] { return now_us() > from_us + 5000; });
    ASSERT_FALSE(sim.light.blank);
  }
  // From the cause on: how long until all was dark. The burst must end by itself, in FAULT.
  double dark_after_us(double cause_us) {
    while (is_under_way() && is_lit()) turn();
    const double dark_us = now_us();
    while (is_under_way()) turn();
    EXPECT_FALSE(is_lit());
    EXPECT_EQ(session.state, lamella_v1_RigState_FAULT);
    for (size_t i = 0; i < sim.light.pulse_count; i++) {
      EXPECT_LE(sim.light.pulses[i].off_us, cause_us + kLimitUs) << "LED pulse " << i;
    }
    for (size_t i = 0; i < sim.light.lamp_count; i++) {
      EXPECT_LE(sim.light.lamps[i].at_us, cause_us + kLimitUs) << "the lamp moved later";
    }
    return dark_us - cause_us;
  }
  void expect_fault(enum lam_part part, const std::string& says) {
    EXPECT_EQ(session.fault_part, part);
    EXPECT_NE(std::string(session.fault).find(says), std::string::npos) << session.fault;
  }

  struct rig rig = test_rig();
  struct hal_sim sim;
  struct store store;
  struct session session;

 private:
  FakeTwin twin_;
  std::vector<uint8_t> block_;
};

// The time of an injected cause that begins this long after the burst's zero.
constexpr double kBeginUs = 100e3;
const std::string kBegin = "begin:100000";

}  // namespace

TEST(LightsOff, WhereTheEmergencyStopIsPressed) {
  Stage stage({"estop", kBegin});
  stage.play_until([&] { return stage.now_us() >= stage.sim.zero_us + kBeginUs - kRestUs; });
  EXPECT_LE(stage.dark_after_us(stage.sim.zero_us + kBeginUs), kLimitUs);
  stage.expect_fault(LAM_PART_ESTOP, "emergency stop");
}

TEST(LightsOff, WhereTheBoardIsTooHot) {
  Stage stage({"hot:150", kBegin});
  stage.play_until([&] { return stage.now_us() >= stage.sim.zero_us + kBeginUs - kRestUs; });
  EXPECT_LE(stage.dark_after_us(stage.sim.zero_us + kBeginUs), kLimitUs);
  stage.expect_fault(LAM_PART_HEAT, "too hot");
}

TEST(LightsOff, WhereTheActuatorIsStuck) {
  Stage stage({"stuck-actuator"});
  stage.play_until([&] { return stage.sim.move_pending; });
  const double stuck_us = stage.sim.moved_us + 1.5 * stage.rig.analyser_move_us;
  EXPECT_LE(stage.dark_after_us(stuck_us), kLimitUs);
  stage.expect_fault(LAM_PART_ACTUATOR, "stuck");
}

TEST(LightsOff, WhereTheLedChainTakesNoFrame) {
  for (int frame : {0, 3}) {
    Stage stage({"spi-error:" + std::to_string(frame)});
    stage.play_until([&] { return stage.sim.shift_count == frame; });
    while (stage.sim.shift_count == frame) stage.turn();
    EXPECT_LE(stage.dark_after_us(stage.now_us()), kLimitUs);
    stage.expect_fault(LAM_PART_LED_CHAIN, "did not take a frame: look at its plug and wires");
    EXPECT_EQ(stage.sim.light.pulse_count, size_t(frame)) << "no pulse with the last frame's codes";
  }
}

TEST(LightsOff, WhereTheDiskCanTakeNoMore) {
  Stage stage;
  stage.play_until_lit_by_leds();
  store_fail(&stage.store, "the disk is full", ENOSPC);
  EXPECT_LE(stage.dark_after_us(stage.now_us()), kLimitUs);
  stage.expect_fault(LAM_PART_DISK, "disk is full");
}

// Cameras are read by another thread here, as a board's are.
TEST(LightsOff, WhereACameraIsGone) {
  static std::atomic<bool> unplugged;
  unplugged = false;
  Stage stage;
  stage.sim.hal.reads_while_playing = true;
  stage.sim.hal.read_photograph = [](void*, unsigned, unsigned, struct hal_photograph* raw) {
    while (!unplugged) usleep(100);
    std::snprintf(raw->error, sizeof raw->error, "the left camera is gone");
    return LAM_HARDWARE;
  };
  stage.play_until([&] { return stage.session.offered > 0; });
  stage.play_until_lit_by_leds();
  unplugged = true;
  while (!collector_has_failed(&stage.session.collector)) usleep(100);
  EXPECT_LE(stage.dark_after_us(stage.now_us()), kLimitUs);
  stage.expect_fault(LAM_PART_CAMERA, "the left camera is gone");
}

TEST(LightsOff, WhereTheHostIsGoneThatTheBurstIsTiedTo) {
  Stage stage;
  session_tie_to_host(&stage.session);
  stage.play_until_lit_by_leds();
  const double cause_us = stage.now_us();
  session_lose_host(&stage.session);
  EXPECT_LE(stage.dark_after_us(cause_us), kLimitUs);
  stage.expect_fault(LAM_PART_OTHER, "host");
}

TEST(LightsOff, WhereTheHostThatTheBurstIsTiedToFallsSilent) {
  Stage stage;
  session_tie_to_host(&stage.session);
  const double silent_us = stage.session.host_heard_us + 500e3;
  EXPECT_LE(stage.dark_after_us(silent_us), kLimitUs);
  stage.expect_fault(LAM_PART_OTHER, "host");
}

TEST(LightsOff, NotWhereATiedHostIsHeardOrAnotherIsLost) {
  Stage tied, free;
  session_tie_to_host(&tied.session);
  while (tied.is_under_way()) {
    tied.turn();
    session_hear_host(&tied.session);
  }
  EXPECT_EQ(tied.session.state, lamella_v1_RigState_RUNNING) << tied.session.fault;
  free.play_until_lit_by_leds();
  session_lose_host(&free.session);
  EXPECT_TRUE(free.is_lit());
}

TEST(LightsOff, WhereTheOperatorAborts) {
  Stage stage;
  stage.play_until_lit_by_leds();
  const double cause_us = stage.now_us();
  EXPECT_EQ(session_abort(&stage.session), LAM_OK);
  EXPECT_FALSE(stage.is_lit());
  EXPECT_EQ(stage.now_us(), cause_us);
  EXPECT_EQ(stage.session.state, lamella_v1_RigState_IDLE);
}

TEST(LightsOff, WhereASequencerThatStalledCouldHaveLeftLedsLitForTooLong) {
  Stage stage;
  stage.play_until_lit_by_leds();
  stage.stall(stage.rig.leds_longest_on_us);
  const double cause_us = stage.now_us();
  stage.turn();
  EXPECT_FALSE(stage.is_lit());
  EXPECT_EQ(stage.now_us(), cause_us) << "the first thing that it does";
  EXPECT_EQ(stage.session.state, lamella_v1_RigState_FAULT);
  stage.expect_fault(LAM_PART_OTHER, "past the lights' limit of 10000 us");
}

TEST(LightsOff, AndStayOffWhereTheEdgeThatWouldLightThemIsTooLate) {
  Stage stage;
  struct player& player = stage.session.roll.takes[0].player;
  stage.play_until([&] {
    const edge& next = stage.session.roll.takes[0].timeline.edges[player.next];
    return stage.session.playing && next.line == EDGE_BLANK && next.value == 0;
  });
  const size_t pulses = stage.sim.light.pulse_count;
  stage.stall(20000);
  stage.turn();
  EXPECT_EQ(stage.sim.light.pulse_count, pulses);
  EXPECT_EQ(stage.session.state, lamella_v1_RigState_FAULT);
}

TEST(LightsOff, OnlyBeyondTheLimit) {
  Stage within({"late-blank:9000"}), beyond({"late-blank:11000"});
  while (within.is_under_way()) within.turn();
  EXPECT_EQ(within.session.state, lamella_v1_RigState_RUNNING) << "marked when it is over";
  EXPECT_GT(within.session.roll.takes[0].player.late_count, 0u);
  while (beyond.is_under_way()) beyond.turn();
  EXPECT_EQ(beyond.session.state, lamella_v1_RigState_FAULT);
  EXPECT_FALSE(beyond.is_lit());
}

TEST(LightsOff, ABurstWithoutACauseIsPlayedToItsEnd) {
  Stage stage;
  while (stage.is_under_way()) stage.turn();
  EXPECT_EQ(stage.session.state, lamella_v1_RigState_RUNNING) << stage.session.fault;
  EXPECT_EQ(stage.sim.light.pulse_count, 8u);
  EXPECT_EQ(stage.session.roll.takes[0].player.late_count, 0u);
}
