// The actuator before the left camera's analyser: one output says where to, two end stops say where
// it is. Without end stops it is believed to arrive after the rig file's time.
#ifndef LAMELLA_FIRMWARE_HAL_LINUX_ACTUATOR_H
#define LAMELLA_FIRMWARE_HAL_LINUX_ACTUATOR_H

#include <stdbool.h>

#include "rig.h"

struct linux_actuator {
  double move_us, longest_us;  // as planned; after which it is stuck
  bool has_stop[2];            // at parallel, at crossed
  bool at_stop[2];
  bool crossed;  // where it is, or is going
  bool moving, untold;
  double started_us, arrived_us;
};

// It stands where the rig file parks it.
void linux_actuator_init(struct linux_actuator* actuator, const struct rig* rig);

void linux_actuator_start(struct linux_actuator* actuator, bool crossed, double at_us);

// An end stop changed.
void linux_actuator_hear(struct linux_actuator* actuator, bool crossed, bool level, double at_us);

// What is true now_us: `moving` ends where no stop can tell.
void linux_actuator_look(struct linux_actuator* actuator, double now_us);

// Once true after each move.
bool linux_actuator_arrived(struct linux_actuator* actuator, double* at_us);

bool linux_actuator_is_stuck(const struct linux_actuator* actuator, double now_us);

#endif
