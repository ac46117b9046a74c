// The lead by which the player goes ahead of an edge is measured, bounded and used.
#include <gtest/gtest.h>

#include <cmath>
#include <deque>

#include "session_bench.h"

extern "C" {
#include "latency.h"
}

namespace {

// A kernel whose clock moves when one waits or calls it.
struct Kernel {
  double now_us = 1000, call_us = 3, moves_after_us = 1;
  int latches = 0, triggers = 0;
  bool trigger = false;
  std::deque<hal_seen_edge> seen;
};

enum lam_status set_line(void* self, enum hal_line line, bool level, double* at_us) {
  auto* kernel = static_cast<Kernel*>(self);
  EXPECT_TRUE(line == HAL_TRIGGER || (line == HAL_LATCH && !level));
  kernel->latches += line == HAL_LATCH;
  if (line == HAL_TRIGGER) {
    kernel->triggers++;
    kernel->trigger = level;
    kernel->seen.push_back({line, level, kernel->now_us + kernel->moves_after_us});
  }
  *at_us = kernel->now_us += kernel->call_us;
  return LAM_OK;
}

bool next_seen(void* self, struct hal_seen_edge* edge) {
  auto* kernel = static_cast<Kernel*>(self);
  if (kernel->seen.empty() || kernel->seen.front().at_us > kernel->now_us - 100) return false;
  *edge = kernel->seen.front();
  kernel->seen.pop_front();
  return true;
}

double now_us(void* self) { return static_cast<Kernel*>(self)->now_us; }

double wait_until_us(void* self, double t_us) {
  auto* kernel = static_cast<Kernel*>(self);
  return kernel->now_us = std::fmax(kernel->now_us, t_us);
}

double measured_lead_us(Kernel* kernel, bool sees_trigger) {
  struct hal hal = {};
  hal.self = kernel;
  hal.sees_trigger = sees_trigger;
  hal.now_us = now_us;
  hal.wait_until_us = wait_until_us;
  hal.set_line = set_line;
  hal.next_seen = next_seen;
  lamella_v1_Latency latency = lamella_v1_Latency_init_zero;
  latency_test(&hal, &latency);
  EXPECT_EQ(latency.lead_us, hal.lead_us);
  EXPECT_EQ(latency.highest_us, 0);
  return hal.lead_us;
}

}  // namespace

TEST(Latency, ALineIsTakenToMoveInTheMiddleOfTheCallAndNoneIsMovedToMeasureIt) {
  Kernel kernel;
  EXPECT_DOUBLE_EQ(measured_lead_us(&kernel, false), 1.5);
  EXPECT_GE(kernel.latches, 100);
  EXPECT_EQ(kernel.triggers, 0);
}

TEST(Latency, ALoopBackTellsWhenTheLineReallyMovedEvenWhereItTellsLate) {
  Kernel kernel;
  EXPECT_NEAR(measured_lead_us(&kernel, true), 1, 1e-9);
  EXPECT_GE(kernel.triggers, 100);
  EXPECT_FALSE(kernel.trigger) << "it ends as it was";
}

TEST(Latency, ALoopBackThatTellsNothingGivesNoLead) {
  Kernel kernel;
  kernel.moves_after_us = INFINITY;
  EXPECT_EQ(measured_lead_us(&kernel, true), 0);
}

TEST(Latency, NothingIsEarlyByMoreThan5MicrosecondsWhateverAKernelTakes) {
  Kernel kernel;
  kernel.call_us = 400;
  EXPECT_EQ(measured_lead_us(&kernel, false), 5);
}

TEST(Latency, EveryEdgeOfALineIsAskedForSoMuchEarlierAndNoOtherIs) {
  Bench bench;
  bench.sim.hal.lead_us = 3;
  bench.burst();
  const struct take& take = bench.session.roll.takes[0];
  size_t lines = 0, others = 0;
  for (size_t i = 0; i < take.timeline.count; i++) {
    const struct edge& edge = take.timeline.edges[i];
    const double early_us = edge.t_us - take.player.played[i].actual_us;
    switch (edge.line) {
      case EDGE_BLANK:
      case EDGE_TRIGGER:
      case EDGE_LATCH:
      case EDGE_LAMP:
        EXPECT_NEAR(early_us, 3, 1e-6) << timeline_line_name(edge.line);
        lines++;
        break;
      case EDGE_SHIFT:
      case EDGE_COMMIT:
      case EDGE_ANALYSER:
        EXPECT_NEAR(early_us, 0, 1e-6) << timeline_line_name(edge.line);
        others++;
        break;
      default:
        break;
    }
  }
  EXPECT_GE(lines, 56u);
  EXPECT_GE(others, 20u);
}
