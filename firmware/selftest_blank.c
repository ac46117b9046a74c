// The wire that all light hangs on, seen behind the gate that drives it, while every level is zero:
// nothing shines. It must follow BLANK, and go dark by itself when the heart stops.
#include <stdio.h>

#include "led_driver.h"
#include "selftest.h"

static const double kFollowsUs = 2000, kHoldsAtLeastMs = 4, kHoldsAtMostMs = 10;
static const double kAwaitUs = 20000;
static const double kLookUs = 100;

// The first edge of BLANK to that level from now on; false where none comes in time.
static bool await_blank(struct hal* hal, bool level, double longest_us, double* at_us) {
  const double end_us = hal->now_us(hal->self) + longest_us;
  struct hal_seen_edge edge;
  for (;;) {
    while (hal->next_seen(hal->self, &edge)) {
      if (edge.line != HAL_BLANK || edge.level != level) continue;
      *at_us = edge.at_us;
      return true;
    }
    if (hal->now_us(hal->self) >= end_us) return false;
    hal->wait_until_us(hal->self, hal->now_us(hal->self) + kLookUs);
  }
}

static void forget_old_edges(struct hal* hal) {
  struct hal_seen_edge edge;
  while (hal->next_seen(hal->self, &edge)) continue;
}

static void judge_hold(struct selftest* test, double beat_us) {
  double dark_us = 0;
  if (!await_blank(test->hal, true, kAwaitUs, &dark_us)) {
    selftest_fail(test, "dark after the last heartbeat",
                  "it stays lit when the heart stops: the monostable, its gate, their wires");
    return;
  }
  struct selftest_reading* reading =
      selftest_read(test, "dark after the last heartbeat", (dark_us - beat_us) * 1e-3, "ms");
  selftest_limit(test, reading, kHoldsAtLeastMs, kHoldsAtMostMs);
  if (reading->verdict == SELFTEST_BAD)
    snprintf(reading->note, sizeof reading->note, "its R and C");
}

// False where the hardware fails.
static bool judge_fall(struct selftest* test) {
  struct hal* hal = test->hal;
  double fell_us = 0, seen_us = 0;
  if (hal_beat(hal) != LAM_OK) return false;
  const double beat_us = hal->now_us(hal->self);
  if (hal->set_line(hal->self, HAL_BLANK, false, &fell_us) != LAM_OK) return false;
  if (!await_blank(hal, false, kFollowsUs, &seen_us)) {
    selftest_fail(test, "lit after BLANK falls",
                  "it stays dark: is a stop pressed, or the monostable's wire off?");
    return true;
  }
  struct selftest_reading* reading =
      selftest_read(test, "lit after BLANK falls", seen_us - fell_us, "us");
  selftest_limit(test, reading, -kFollowsUs, kFollowsUs);
  judge_hold(test, beat_us);
  return true;
}

bool selftest_blank(struct selftest* test) {
  struct hal* hal = test->hal;
  if (test->rig->board.given && test->rig->board.blank_seen_line[0] == '\0') {
    selftest_skip(test, "XBLNK", "the rig file names no linux.blank_seen_line");
    return false;
  }
  hal->lights_off(hal->self);
  const bool dark = led_driver_darken(hal, test->rig) == LAM_OK;
  forget_old_edges(hal);
  if (!dark || !judge_fall(test)) selftest_fail(test, "XBLNK", hal->error);
  hal->lights_off(hal->self);
  return false;
}
