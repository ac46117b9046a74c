// Photographs are collected beside the player, which never waits for them.
#include <gtest/gtest.h>
#include <sched.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include "session_bench.h"

namespace {

// Cameras that give no photograph before they are let: whoever waits for one waits for ever.
struct SlowCameras {
  explicit SlowCameras(struct hal* hal) : inner(*hal) {
    self = this;
    hal->reads_while_playing = true;
    hal->read_photograph = read;
  }

  static enum lam_status read(void*, unsigned shot, unsigned camera, hal_photograph* photograph) {
    self->begun++;
    self->policy = sched_getscheduler(0);
    while (!self->open) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (static_cast<int>(shot) == self->failing_shot) {
      snprintf(photograph->error, sizeof photograph->error, "the camera is gone");
      return LAM_HARDWARE;
    }
    return self->inner.read_photograph(self->inner.self, shot, camera, photograph);
  }

  static SlowCameras* self;
  struct hal inner;
  std::atomic<bool> open{false};
  std::atomic<int> begun{0}, policy{-1};
  std::atomic<int> failing_shot{-1};
};
SlowCameras* SlowCameras::self = nullptr;

// Until the first take has been played to its end.
void play(session* session) {
  session_work(session);
  while (session->playing) session_work(session);
}

}  // namespace

TEST(Collector, EdgesArePlayedToTheEndWhileTheFirstPhotographIsStillBeingRead) {
  Bench bench;
  SlowCameras cameras(&bench.sim.hal);
  ASSERT_EQ(session_request_burst(&bench.session, false), LAM_OK);
  play(&bench.session);
  EXPECT_EQ(bench.session.state, lamella_v1_RigState_RUNNING);
  while (cameras.begun == 0) std::this_thread::yield();
  EXPECT_EQ(cameras.begun, 1);
  EXPECT_EQ(collector_kept(&bench.session.collector), 0u);
  const struct take& take = bench.session.roll.takes[0];
  for (size_t i = 0; i < take.timeline.count; i++) {
    EXPECT_NEAR(take.player.played[i].actual_us, take.timeline.edges[i].t_us, 1e-3) << i;
  }
  cameras.open = true;
  while (session_work(&bench.session)) continue;
  EXPECT_EQ(bench.session.done.frame_count, 40u);
  EXPECT_FALSE(bench.session.done.marked) << bench.session.done.verdict;
}

TEST(Collector, HasNormalPriority) {
  Bench bench;
  SlowCameras cameras(&bench.sim.hal);
  cameras.open = true;
  bench.session.hal->reads_while_playing = false;  // its twin may not be asked while edges move
  bench.burst();
  EXPECT_EQ(cameras.policy, SCHED_OTHER);
}

TEST(Collector, AFailingPhotographStopsTheBurstWithLightsOff) {
  Bench bench;
  SlowCameras cameras(&bench.sim.hal);
  cameras.failing_shot = 0;
  cameras.open = true;
  ASSERT_EQ(session_request_burst(&bench.session, false), LAM_OK);
  while (session_work(&bench.session)) continue;
  EXPECT_EQ(bench.session.state, lamella_v1_RigState_FAULT);
  EXPECT_STREQ(bench.session.fault, "the camera is gone");
  EXPECT_TRUE(bench.sim.light.blank);
  EXPECT_EQ(store_held(&bench.photographs), 0u);
}

TEST(Collector, AnAbortedBurstLeavesNothingEvenWhileACameraIsStillBusy) {
  Bench bench;
  SlowCameras cameras(&bench.sim.hal);
  ASSERT_EQ(session_request_burst(&bench.session, false), LAM_OK);
  play(&bench.session);
  while (cameras.begun == 0) std::this_thread::yield();
  EXPECT_EQ(session_abort(&bench.session), LAM_OK);
  EXPECT_TRUE(bench.sim.light.blank);
  EXPECT_EQ(session_request_burst(&bench.session, false), LAM_WRONG_STATE);
  EXPECT_NE(std::string(bench.session.refusal).find("a camera still reads"), std::string::npos)
      << bench.session.refusal;
  cameras.open = true;
  while (session_work(&bench.session)) continue;
  EXPECT_EQ(store_held(&bench.photographs), 0u);
  bench.session.hal->reads_while_playing = false;
  EXPECT_EQ(bench.burst().frame_count, 40u);
}

TEST(Collector, ASessionThatIsClosedMidwayIsForgotten) {
  Bench bench;
  SlowCameras cameras(&bench.sim.hal);
  ASSERT_EQ(session_request_burst(&bench.session, false), LAM_OK);
  play(&bench.session);
  while (cameras.begun == 0) std::this_thread::yield();
  std::thread opener([&cameras] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    cameras.open = true;
  });
  session_close(&bench.session);
  opener.join();
  EXPECT_EQ(store_held(&bench.photographs), 0u);
}

TEST(Collector, WaitsAreMeasuredWithoutALineMoved) {
  Bench bench;
  session_test_latency(&bench.session);
  lamella_v1_Status status;
  session_status(&bench.session, &status);
  EXPECT_TRUE(status.has_latency);
  EXPECT_GE(status.latency.waits, 200u);
  EXPECT_NEAR(status.latency.highest_us, 0, 1e-3);  // of a clock that moves when one waits
  EXPECT_EQ(bench.sim.seen_count, 0u);
  lamella_v1_TimingEdges page;
  bench.burst();
  session_timing(&bench.session, 0, &page);
  EXPECT_EQ(page.latency.waits, status.latency.waits);
}
