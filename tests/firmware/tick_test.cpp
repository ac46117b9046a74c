// The kernel's timer and the burst's zero.
#include <cmath>
#include <ctime>

#include "session_bench.h"

extern "C" {
#include "hal_linux_time.h"
#include "tick.h"
}

namespace {

// How far the nearest critical edge of a take is due from a tick.
double nearest_us(const struct hal& hal, const struct take& take) {
  double nearest = INFINITY;
  for (size_t i = 0; i < take.timeline.count; i++) {
    const struct edge& edge = take.timeline.edges[i];
    if (edge.line != EDGE_BLANK && edge.line != EDGE_TRIGGER) continue;
    const double due_us = take.player.zero_us + edge.t_us;
    nearest = std::fmin(nearest, std::fabs(std::remainder(due_us - hal.tick_at_us, hal.tick_us)));
  }
  return nearest;
}

// The zero of a burst's first take on a rig whose kernel's timer strikes at tick_at_us.
double zero_us(Bench* bench, double tick_us, double tick_at_us) {
  bench->sim.hal.tick_us = tick_us;
  bench->sim.hal.tick_at_us = tick_at_us;
  bench->burst();
  return bench->session.roll.takes[0].player.zero_us;
}

}  // namespace

TEST(Tick, ABurstBeginsWhereNoCriticalEdgeMeetsTheKernelsTimer) {
  Bench without;
  const double first_us = zero_us(&without, 0, 0);
  const struct timeline& timeline = without.session.roll.takes[0].timeline;
  for (size_t i = 0; i < timeline.count; i++) {
    if (timeline.edges[i].line != EDGE_BLANK) continue;
    Bench bench;
    const double moved_us = zero_us(&bench, 4000, first_us + timeline.edges[i].t_us - 3);
    EXPECT_GT(moved_us, first_us) << "at the first vblank, edge " << i << " meets a tick";
    EXPECT_GE(nearest_us(bench.sim.hal, bench.session.roll.takes[0]), 4) << i;
    EXPECT_STREQ(bench.session.done.verdict, without.session.done.verdict);
  }
}

TEST(Tick, WhereEveryVblankMeetsOneTheBurstIsTakenAllTheSame) {
  Bench bench;
  zero_us(&bench, 20, 0);  // more often than an interrupt is long
  EXPECT_FALSE(bench.session.done.marked);
  EXPECT_EQ(bench.session.done.frame_count, 40u);
}

TEST(Tick, AnEdgeIsMetShortlyAfterATickAndNotBeforeIt) {
  struct hal hal = {};
  hal.tick_us = 4000;
  hal.tick_at_us = 5e9 + 1234;
  struct timeline timeline = {};
  timeline.count = 1;
  timeline.edges[0] = {
      .t_us = 100, .tolerance_us = 50, .line = EDGE_TRIGGER, .value = 1, .step = 0};
  const auto meets = [&](double after_us) {
    return tick_meets_edge(&hal, &timeline, 1234 + after_us - 100 + 3 * 4000);
  };
  EXPECT_TRUE(meets(0));
  EXPECT_TRUE(meets(10));
  EXPECT_FALSE(meets(40));
  EXPECT_FALSE(meets(2000));
  EXPECT_FALSE(meets(-40));
  timeline.edges[0].line = EDGE_LATCH;
  EXPECT_FALSE(meets(10)) << "no light and no exposure hangs on it";
}

TEST(Tick, TheKernelTellsHowOftenItsTimerStrikes) {
  struct timespec every;
  clock_getres(CLOCK_MONOTONIC_COARSE, &every);
  if (every.tv_nsec < 100000) GTEST_SKIP() << "this kernel's coarse clock is set by no tick";
  double at_us = 0;
  const double before_us = linux_now_us(), tick_us = linux_tick_us(&at_us);
  EXPECT_DOUBLE_EQ(tick_us, (double)every.tv_nsec * 1e-3);
  // One that was seen late is moved back to where the others say that it was.
  EXPECT_GT(at_us, before_us - tick_us);
  EXPECT_LE(at_us, linux_now_us());
}
