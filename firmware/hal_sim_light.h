// The light of the simulated rig over time, from what the lines really did: driver chain, BLANK,
// projector, analyser. An exposure is cut out of it as the report that the digital twin gets.
#ifndef LAMELLA_FIRMWARE_HAL_SIM_LIGHT_H
#define LAMELLA_FIRMWARE_HAL_SIM_LIGHT_H

#include <stdbool.h>

#include "hal.h"
#include "hal_sim_chain.h"
#include "hal_sim_faults.h"
#include "rig.h"

enum { SIM_MAX_EVENTS = 128 };

// LED outputs on, with the codes latched then.
struct sim_pulse {
  double on_us, off_us;    // off_us is infinite while they are on
  double counter_zero_us;  // BLANK fell: the PWM counters started
  uint16_t codes[RIG_MAX_LEDS];
};

struct sim_flip {
  double vblank_us;
  struct hal_pattern pattern;
};

struct sim_lamp {
  double at_us;
  bool on;
};

struct sim_move {
  double from_us, to_us, from_rad, to_rad;
};

struct sim_light {
  const struct rig* rig;
  const struct sim_faults* faults;
  struct sim_chain chain;
  bool blank;
  double analyser_rad;  // where it stood at the first event
  struct sim_pulse pulses[SIM_MAX_EVENTS];
  size_t pulse_count;
  struct sim_flip flips[SIM_MAX_EVENTS];
  size_t flip_count;
  struct sim_lamp lamps[SIM_MAX_EVENTS];
  size_t lamp_count;
  struct sim_move moves[SIM_MAX_EVENTS];
  size_t move_count;
};

void sim_light_init(struct sim_light* light, const struct rig* rig,
                    const struct sim_faults* faults);
// Forgets the past: dark, lamp off, the analyser standing where it is going.
void sim_light_restart(struct sim_light* light);

// Events come in order of time; false where a history is full.
bool sim_light_blank(struct sim_light* light, bool level, double t_us);
bool sim_light_latch(struct sim_light* light, bool level, double t_us);
bool sim_light_flip(struct sim_light* light, struct hal_pattern pattern, double vblank_us);
bool sim_light_lamp(struct sim_light* light, bool on, double t_us);
bool sim_light_move(struct sim_light* light, double to_rad, double from_us, double to_us);

double sim_light_analyser_rad(const struct sim_light* light, double t_us);

// What camera 0 (left) or 1 (right) was exposed to from open_us to close_us. False where more
// happened than a report can hold.
bool sim_light_report(const struct sim_light* light, unsigned camera, double open_us,
                      double close_us, lamella_v1_ExposureReport* report);

#endif
