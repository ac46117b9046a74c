#include "hal_sim_chain.h"

#include <string.h>

// Cells that the bits really pass.
static size_t chain_length(const struct sim_chain* chain) {
  return CHAIN_BITS - (chain->missing_chip > 0 ? CHAIN_CHIP_BITS : 0);
}

// Whether a bit still moves on behind cell `at`: past a broken chip only what was there before.
static size_t first_cell_after_break(const struct sim_chain* chain) {
  const size_t length = chain_length(chain);
  const size_t after = (size_t)chain->broken_chip * CHAIN_CHIP_BITS;
  return chain->broken_chip > 0 && after < length ? after : length;
}

// At most the chain's length of bits, the first of them number `from` of the stream.
static void shift_some(struct sim_chain* chain, const uint8_t* stream, size_t from, size_t count,
                       uint8_t* pushed_out) {
  const size_t length = chain_length(chain), after = first_cell_after_break(chain);
  const bool last_passes_nothing = chain->broken_chip > 0 && after == length;
  for (size_t j = 0; pushed_out != NULL && j < count; j++) {
    const size_t bit = from + j, cell = length - 1 - j;
    const bool passes = !last_passes_nothing && (after == length || cell >= after);
    if (passes) pushed_out[bit / 8] |= (uint8_t)(chain->cells[cell] << (7 - bit % 8));
  }
  memmove(chain->cells + count, chain->cells, length - count);
  for (size_t j = 0; j < count; j++) {
    const size_t bit = from + j;
    chain->cells[count - 1 - j] = stream[bit / 8] >> (7 - bit % 8) & 1;
  }
  if (after == length) return;
  memset(chain->cells + after, 0, after + count < length ? count : length - after);
}

void sim_chain_shift(struct sim_chain* chain, const uint8_t* stream, size_t bits,
                     uint8_t* pushed_out) {
  const size_t length = chain_length(chain);
  chain->latch_at_clock = chain->latch;
  if (pushed_out != NULL) memset(pushed_out, 0, (bits + 7) / 8);
  for (size_t from = 0; from < bits; from += length) {
    shift_some(chain, stream, from, bits - from < length ? bits - from : length, pushed_out);
  }
}

// Levels, functions and what is on the way: all of it is random, as in a chip that has just got its
// supply.
void sim_chain_power_up(struct sim_chain* chain, bool has_functions) {
  uint32_t seed = 0x1e3779b9;  // xorshift32
  chain->has_functions = has_functions;
  if (!has_functions) return;
  for (size_t i = 0; i < CHAIN_BITS; i++) {
    seed ^= seed << 13;
    seed ^= seed >> 17;
    seed ^= seed << 5;
    chain->cells[i] = seed >> 31;
    chain->latched[i] = seed >> 30 & 1;
    chain->functions[i] = seed >> 29 & 1;
  }
}

static void latch_functions(struct sim_chain* chain) {
  for (int place = 0; place < CHAIN_CHIPS; place++) {
    const int first = place * CHAIN_CHIP_BITS;
    if (place == chain->forgetful_chip - 1) continue;
    memcpy(chain->functions + first, chain->cells + first, CHAIN_FUNCTION_BITS);
  }
}

// What the outputs tell of themselves is above the functions: none is open, shorted or hot.
static void load_status(struct sim_chain* chain) {
  for (int place = 0; place < CHAIN_CHIPS; place++) {
    const int first = place * CHAIN_CHIP_BITS;
    memset(chain->cells + first, 0, CHAIN_CHIP_BITS);
    memcpy(chain->cells + first, chain->functions + first, CHAIN_FUNCTION_BITS);
  }
}

void sim_chain_latch(struct sim_chain* chain, bool level) {
  const bool rises = level && !chain->latch;
  chain->latch = level;
  if (!rises) return;
  if (chain->has_functions && chain->latch_at_clock) {
    latch_functions(chain);
    return;
  }
  memcpy(chain->latched, chain->cells, sizeof chain->latched);
  if (chain->has_functions) load_status(chain);
}

// With any other functions its current is too small for the power stage, or stops after one period:
// no light, to make it simple.
static bool drives(const struct sim_chain* chain, int place) {
  if (!chain->has_functions) return true;
  const uint8_t* functions = chain->functions + place * CHAIN_CHIP_BITS;
  for (int bit = 0; bit < CHAIN_FUNCTION_BITS; bit++) {
    const bool is_one = bit < 196;  // up to auto repeat; counters of 12 bits above
    if (functions[bit] != is_one) return false;
  }
  return true;
}

uint16_t sim_chain_code(const struct sim_chain* chain, int chip, int output) {
  const int missing = chain->missing_chip - 1;
  if (chain->missing_chip > 0 && chip == missing) return 0;
  const int place = chain->missing_chip > 0 && chip > missing ? chip - 1 : chip;
  if (!drives(chain, place)) return 0;
  // Within a driver the cell farthest from its input is the top bit of output 23.
  const uint8_t* cells = chain->latched + place * CHAIN_CHIP_BITS + output * CHAIN_CODE_BITS;
  uint16_t code = 0;
  for (int bit = CHAIN_CODE_BITS - 1; bit >= 0; bit--) code = (uint16_t)(code << 1 | cells[bit]);
  return code;
}
