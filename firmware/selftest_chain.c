#include "selftest_chain.h"

#include <string.h>

// A length is believed where less than this share of bits disagrees: half do by chance.
static const double kMostWrong = 0.1;
enum { kLeastCompared = 512 };

void chain_trial_begin(struct chain_trial* trial) {
  memset(trial, 0, sizeof *trial);
  trial->seed = 0x1e3779b9;
  trial->first_wrong = -1;
  trial->all_zeros = trial->all_ones = true;
}

static uint8_t next_byte(uint32_t* seed) {  // xorshift32
  *seed ^= *seed << 13;
  *seed ^= *seed >> 17;
  *seed ^= *seed << 5;
  return (uint8_t)(*seed >> 24);
}

const uint8_t* chain_trial_stream(struct chain_trial* trial) {
  memcpy(trial->before, trial->sent, CHAIN_BYTES);
  for (int i = 0; i < CHAIN_BYTES; i++) trial->sent[i] = next_byte(&trial->seed);
  trial->streams++;
  return trial->sent;
}

static int bit_of(const uint8_t* stream, int bit) { return stream[bit / 8] >> (7 - bit % 8) & 1; }

// The bit that went in `length` clocks before bit `place` of the newest stream.
static int expected(const struct chain_trial* trial, int place, int length) {
  const int at = place - length;
  return at >= 0 ? bit_of(trial->sent, at) : bit_of(trial->before, CHAIN_BITS + at);
}

// Bits that disagree if the chain were `length` long; the first of them.
static int disagreements(const struct chain_trial* trial, const uint8_t* out, int length,
                         int* compared, int* first) {
  const int from = length > CHAIN_BITS ? length - CHAIN_BITS : 0;
  int wrong = 0;
  *first = -1;
  for (int i = from; i < CHAIN_BITS; i++) {
    if (bit_of(out, i) == expected(trial, i, length)) continue;
    if (wrong++ == 0) *first = i;
  }
  *compared = CHAIN_BITS - from;
  return wrong;
}

// Looks no further than it takes to tell.
static bool fits(const struct chain_trial* trial, const uint8_t* out, int length) {
  int wrong = 0;
  for (int i = length > CHAIN_BITS ? length - CHAIN_BITS : 0; i < CHAIN_BITS; i++) {
    wrong += bit_of(out, i) != expected(trial, i, length);
    if (wrong > kMostWrong * kLeastCompared) return false;
  }
  return true;
}

static int find_length(const struct chain_trial* trial, const uint8_t* out) {
  if (fits(trial, out, CHAIN_BITS)) return CHAIN_BITS;
  for (int length = 1; length <= 2 * CHAIN_BITS - kLeastCompared; length++) {
    if (fits(trial, out, length)) return length;
  }
  return 0;
}

void chain_trial_take(struct chain_trial* trial, const uint8_t pushed_out[CHAIN_BYTES]) {
  if (trial->streams < 2) return;  // what was in the chain before is not known
  for (int i = 0; i < CHAIN_BYTES; i++) {
    trial->all_zeros = trial->all_zeros && pushed_out[i] == 0;
    trial->all_ones = trial->all_ones && pushed_out[i] == 0xFF;
  }
  const bool silent = trial->all_zeros || trial->all_ones;
  if (trial->length == 0 && !silent) trial->length = find_length(trial, pushed_out);
  if (trial->length == 0) return;
  int compared = 0, first = -1;
  trial->wrong += disagreements(trial, pushed_out, trial->length, &compared, &first);
  trial->compared += compared;
  const int place = first - trial->length;
  if (first >= 0 && trial->first_wrong < 0) {
    trial->first_wrong = place >= 0 ? place : CHAIN_BITS + place;
  }
}

void chain_place(int place, int* chip, int* output, int* bit) {
  *chip = CHAIN_CHIPS - 1 - place / CHAIN_CHIP_BITS;
  *output = CHAIN_OUTPUTS - 1 - place % CHAIN_CHIP_BITS / CHAIN_CODE_BITS;
  *bit = CHAIN_CODE_BITS - 1 - place % CHAIN_CODE_BITS;
}
