#include "hal_linux_actuator.h"

// A move that takes half as long again as the rig file says will not end by itself.
static const double kStuckShare = 1.5;

void linux_actuator_init(struct linux_actuator* actuator, const struct rig* rig) {
  *actuator = (struct linux_actuator){
      .move_us = rig->analyser_move_us,
      .longest_us = kStuckShare * rig->analyser_move_us,
      .has_stop = {rig->board.at_parallel_line[0] != '\0', rig->board.at_crossed_line[0] != '\0'},
      .crossed = rig->analyser_parks_crossed,
  };
}

void linux_actuator_start(struct linux_actuator* actuator, bool crossed, double at_us) {
  const bool stands_there = crossed == actuator->crossed && !actuator->moving;
  actuator->crossed = crossed;
  actuator->untold = true;
  actuator->started_us = actuator->arrived_us = at_us;
  actuator->moving = !stands_there;
}

static void stop(struct linux_actuator* actuator, double at_us) {
  actuator->moving = false;
  actuator->arrived_us = at_us;
}

void linux_actuator_hear(struct linux_actuator* actuator, bool crossed, bool level, double at_us) {
  actuator->at_stop[crossed] = level;
  const bool wanted = crossed == actuator->crossed;
  if (actuator->moving && wanted && level && at_us >= actuator->started_us) stop(actuator, at_us);
}

void linux_actuator_look(struct linux_actuator* actuator, double now_us) {
  const double due_us = actuator->started_us + actuator->move_us;
  const bool unseen = !actuator->has_stop[actuator->crossed];
  if (actuator->moving && unseen && now_us >= due_us) stop(actuator, due_us);
}

bool linux_actuator_arrived(struct linux_actuator* actuator, double* at_us) {
  if (actuator->moving || !actuator->untold) return false;
  actuator->untold = false;
  *at_us = actuator->arrived_us;
  return true;
}

bool linux_actuator_is_stuck(const struct linux_actuator* actuator, double now_us) {
  return actuator->moving && now_us > actuator->started_us + actuator->longest_us;
}
