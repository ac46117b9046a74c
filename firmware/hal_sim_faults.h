// Faults that the simulated hardware has, one of each kind at most. The firmware is not told.
#ifndef LAMELLA_FIRMWARE_HAL_SIM_FAULTS_H
#define LAMELLA_FIRMWARE_HAL_SIM_FAULTS_H

#include <stdbool.h>
#include <stddef.h>

#include "rig.h"

struct sim_faults {
  int flipped_bit;           // of every stream into the driver chain; -1: none
  int stuck_bit;             // of every stream: arrives as 1; -1: none
  int missing_chip;          // the wires go past this one; -1: none
  int broken_chip;           // passes no bit on to the next; -1: none
  int forgetful_chip;        // takes no functions, where chips have some; -1: none
  int dead_led, weak_led;    // -1: none; a weak one gives half its light
  int swapped_leds[2];       // each is wired where the other should be; -1: none
  double late_blank_us;      // BLANK falls this much late
  int late_pulse;            // in the burst's light pulse of this number alone; -1: in every one
  int dropped_shot;          // both cameras miss the burst's trigger of this number; -1: none
  double slow_actuator;      // moves take this many times as long; 1: as the rig file says
  bool stuck_actuator;       // takes the command and stays where it is
  int missing_camera;        // hears no trigger; -1: none
  int broken_shift;          // of the burst's LED frames this one fails to be sent; -1: none
  bool frozen_projector;     // never flips
  bool dead_monostable;      // does not blank when the heart stops
  bool estopped;             // the LED supply is cut
  double hottest_c;          // NaN: as cool as the air around
  double begin_us;           // from a burst's zero: no e-stop and no heat before; 0: since ever
  double press_us, hold_us;  // the start button goes down then, since power-on, for so long
};

extern const struct sim_faults kSimNoFaults;

// What sim_faults_parse() reads, for a usage text.
#define SIM_FAULT_NAMES                                                                \
  "    flip-bit:N stuck-bit:N missing-chip:N broken-chip:N forgetful-chip:N\n"         \
  "    dead-led:N weak-led:N swapped-leds:N:M late-blank:US[:PULSE] drop-frame:SHOT\n" \
  "    missing-camera:N slow-actuator:FACTOR stuck-actuator spi-error:FRAME estop\n"   \
  "    frozen-projector dead-monostable hot:CELSIUS begin:US press:AT_US:FOR_US\n"

// Reads one fault into `faults`. False where it is none.
bool sim_faults_parse(const char* text, struct sim_faults* faults);

// Which of SIM_FAULT_NAMES `text` begins with, from 0; -1: none.
int sim_faults_kind(const char* text);

// Why `text` is none: no such fault, or not with what follows its name.
void sim_faults_explain(const char* text, char why[160]);

// Whether what the faults name by number is there; where not, `error` says what there is.
bool sim_faults_fit(const struct sim_faults* faults, const struct rig* rig, char error[160]);

#endif
