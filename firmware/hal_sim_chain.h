// The simulated rig's LED drivers: seven in a row, of the kind with functions (TLC5951) or without.
#ifndef LAMELLA_FIRMWARE_HAL_SIM_CHAIN_H
#define LAMELLA_FIRMWARE_HAL_SIM_CHAIN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "led_chain.h"

// Cell 0 is where bits enter; a bit moves one cell on with every clock. Within a chip cell N is bit
// N of its register.
struct sim_chain {
  uint8_t cells[CHAIN_BITS];
  uint8_t latched[CHAIN_BITS];
  uint8_t functions[CHAIN_BITS];  // the first CHAIN_FUNCTION_BITS of each chip's
  bool has_functions;
  bool latch, latch_at_clock;  // its level now, and when the last bit came
  int missing_chip;            // the chip counted from 1 that the wires go past; 0: none
  int broken_chip;             // the chip counted from 1 that passes nothing on; 0: none
  int forgetful_chip;          // the chip counted from 1 that takes no functions; 0: none
};

void sim_chain_power_up(struct sim_chain* chain, bool has_functions);

// pushed_out, where it is not NULL, gets as many bits that left the far end.
void sim_chain_shift(struct sim_chain* chain, const uint8_t* stream, size_t bits,
                     uint8_t* pushed_out);

// LATCH moves. Its rising edge takes what was shifted in: as functions where LATCH was high at the
// last clock, otherwise as levels, and the functions are shifted out next.
void sim_chain_latch(struct sim_chain* chain, bool level);

// The code that an output's driver now compares its counter with.
uint16_t sim_chain_code(const struct sim_chain* chain, int chip, int output);

#endif
