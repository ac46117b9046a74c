// calibration.json, a lamella.v1.Session in proto3 JSON, as far as the daemon reads it: enough to
// tell, before a burst is taken, that a host could make nothing of it.
#ifndef LAMELLA_FIRMWARE_CALIBRATION_H
#define LAMELLA_FIRMWARE_CALIBRATION_H

#include <stdbool.h>
#include <stddef.h>

#include "rig_camera.h"

enum { CALIBRATION_WHY_CHARS = 240 };

// Whether it has what a session needs of a rig (format, LEDs, two cameras, projector), and cameras
// as large as `own`, the rig file's (NULL: how large photographs will be is not known here). False
// with a reason of one line, which says where and what to do.
bool calibration_check(const char* text, size_t length, const struct rig_camera* own,
                       char why[CALIBRATION_WHY_CHARS]);

#endif
