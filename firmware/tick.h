// The kernel's timer interrupt: it delays an edge that it meets.
#ifndef LAMELLA_FIRMWARE_TICK_H
#define LAMELLA_FIRMWARE_TICK_H

#include <stdbool.h>

#include "hal.h"
#include "timeline.h"

// Whether a critical edge (BLANK, TRIGGER) of a timeline with this zero is due where the kernel's
// timer may interrupt the player. False where the rig has no such timer.
bool tick_meets_edge(const struct hal* hal, const struct timeline* timeline, double zero_us);

#endif
