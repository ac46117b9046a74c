// A rig in memory: time moves only when one waits (or passes for real), light comes from bits.
#ifndef LAMELLA_FIRMWARE_HAL_SIM_H
#define LAMELLA_FIRMWARE_HAL_SIM_H

#include "hal.h"
#include "hal_sim_light.h"

enum sim_clock { SIM_CLOCK_VIRTUAL, SIM_CLOCK_REAL };

// Faults that the simulated hardware has. The firmware is not told.
struct sim_faults {
  int flipped_bit;       // of every stream into the driver chain; -1: none
  double late_blank_us;  // BLANK falls this much late
  int late_pulse;        // in the light pulse of this number alone; -1: in every one
  int dropped_shot;      // both cameras miss the trigger of this number; -1: none
  double slow_actuator;  // moves take this many times as long; 1: as the rig file says
};

extern const struct sim_faults kSimNoFaults;

// Reads "flip-bit:N", "late-blank:US", "late-blank:US:PULSE", "drop-frame:SHOT" or
// "slow-actuator:FACTOR" into `faults`. Pulses and shots count from 0 in each burst.
bool sim_faults_parse(const char* text, struct sim_faults* faults);

struct sim_shot {
  double open_us, close_us;
  bool missed;  // triggered, or over, during the readout of the one before
};

struct hal_sim {
  struct hal hal;
  const struct rig* rig;
  enum sim_clock clock;
  struct sim_faults faults;
  int twin_socket;
  double virtual_now_us;
  struct sim_light light;
  struct sim_shot shots[SIM_MAX_EVENTS];
  size_t shot_count;
  bool triggered;
  int pulse_count;                                // times that BLANK fell in this burst
  struct hal_seen_edge seen[2 * SIM_MAX_EVENTS];  // BLANK and TRIGGER are looped back
  size_t seen_count, seen_given;
  double last_vblank_us;  // some vblank: they come at whole refresh periods from it
  bool flip_pending, move_pending;
};

// The rig stands dark with its analyser parked. `twin_path` NULL: no photographs can be read.
enum lam_status hal_sim_open(struct hal_sim* sim, const struct rig* rig, enum sim_clock clock,
                             struct sim_faults faults, const char* twin_path);

#endif
