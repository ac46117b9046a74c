// calibration.json, a lamella.v1.Session in proto3 JSON: whatever a host refuses of it is refused
// before a burst is taken, as a burst keeps the calibration that it was taken with.
#ifndef LAMELLA_FIRMWARE_CALIBRATION_H
#define LAMELLA_FIRMWARE_CALIBRATION_H

#include <stdbool.h>
#include <stddef.h>

#include "rig.h"

enum { CALIBRATION_WHY_CHARS = 320 };

// Whether a host can use it (proto/PROTOCOL.md, "The calibration") and it is of this rig: its LEDs,
// its patterns, its projector, and cameras as large as `own`, the rig file's (NULL: how large
// photographs will be is not known here). False with a reason of one line, which says where and
// what to do.
bool calibration_check(const char* text, size_t length, const struct rig* rig,
                       const struct rig_camera* own, char why[CALIBRATION_WHY_CHARS]);

#endif
