// When a step happens after the steps before it.
#ifndef LAMELLA_FIRMWARE_BURST_CLOCK_H
#define LAMELLA_FIRMWARE_BURST_CLOCK_H

#include "burst.h"

// What the next step's times depend on.
struct burst_clock {
  double close_us;  // of the last exposure
  bool any_step, lamp_on, crossed;
};

// Times the next step, as soon as every condition holds, and moves the clock on to its end. A step
// that may begin later ends later or at the same time, never sooner.
void burst_clock_step(const struct rig* rig, const struct burst_step* step,
                      struct burst_clock* clock, struct step_times* times);

#endif
