// Which photographs of a burst are taken again, and when: a second, short timeline, planned and
// judged like the first, with the light and the heat of what was played before.
//
// Every bad step is wanted once; a step whose retake is bad too is no accident and marks the burst.
// Half of a parallel/cross pair is retaken alone while it comes no farther from its partner than
// the burst's own widest pair: S is their difference, of a subject that moves. Beyond that the
// partner is taken again with it.
#ifndef LAMELLA_FIRMWARE_RETAKE_H
#define LAMELLA_FIRMWARE_RETAKE_H

#include "roll.h"
#include "timeline.h"

struct retake {
  struct burst_plan plan;
  struct timeline timeline;
  double rest_us;     // on the rig's clock: from here on nothing of the last take is under way
  char why_not[128];  // why a bad step is not taken again; "" where every one is
};

// Finds as many of the bad steps as may be taken again from now_us on. False where there are none.
bool retake_find(const struct roll* roll, bool stands_crossed, double now_us,
                 struct retake* retake);

#endif
