// How late a wait for a moment ends on this machine, as the player waits: no line is moved.
#ifndef LAMELLA_FIRMWARE_LATENCY_H
#define LAMELLA_FIRMWARE_LATENCY_H

#include "hal.h"
#include "proto/link.pb.h"

void latency_test(struct hal* hal, lamella_v1_Latency* latency);

#endif
