// How late a wait for a moment ends on this machine, as the player waits, and how long the kernel
// takes to move a line.
#ifndef LAMELLA_FIRMWARE_LATENCY_H
#define LAMELLA_FIRMWARE_LATENCY_H

#include "hal.h"
#include "proto/link.pb.h"

// Sets hal->lead_us, by which the player goes ahead of every line's edge, to the median time from
// set_line() to the move, 5 us at most: where a loop-back input sees TRIGGER, that is pulsed and
// the kernel's own time of its edges counts; else LATCH is set to the 0 that it has, no line moves,
// and the move is taken to lie in the middle of the call. Lights are off and no camera is armed.
void latency_test(struct hal* hal, lamella_v1_Latency* latency);

#endif
