// What a sensor that is known by name wants of the rig file's other keys.
#ifndef LAMELLA_FIRMWARE_RIG_SENSOR_H
#define LAMELLA_FIRMWARE_RIG_SENSOR_H

#include "rig.h"

// Whether the keys of a board's cameras are such that rig->sensor.name would work; else `error`
// says which contradicts it. RIG_SENSOR_OTHER wants nothing.
bool rig_sensor_fits(const struct rig* rig, char error[160]);

#endif
