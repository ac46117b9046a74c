// What is said of a burst when it is over.
#ifndef LAMELLA_FIRMWARE_VERDICT_H
#define LAMELLA_FIRMWARE_VERDICT_H

#include "proto/link.pb.h"
#include "roll.h"

// `frames` photographs were kept; `why_not` says why a bad shot was not taken again, or is "".
// burst_id is the caller's to set.
void verdict_write(const struct roll* roll, unsigned frames, const char* why_not,
                   lamella_v1_BurstDone* done);

#endif
