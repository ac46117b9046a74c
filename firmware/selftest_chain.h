// What comes back from the LED chain's far end: how long the chain is, and which bits are wrong.
// Pseudo-random streams go in; no hardware here.
#ifndef LAMELLA_FIRMWARE_SELFTEST_CHAIN_H
#define LAMELLA_FIRMWARE_SELFTEST_CHAIN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "led_chain.h"

enum { CHAIN_TRIAL_STREAMS = 10 };

struct chain_trial {
  uint32_t seed;
  uint8_t before[CHAIN_BYTES], sent[CHAIN_BYTES];  // the last two streams
  int streams;
  int length;  // of the chain in bits, found from the second stream on; 0: not found
  long compared, wrong;
  int first_wrong;           // place in the stream, from 0; -1: none
  bool all_zeros, all_ones;  // of everything that came back
};

void chain_trial_begin(struct chain_trial* trial);

// The next stream to shift in.
const uint8_t* chain_trial_stream(struct chain_trial* trial);

// What left the far end meanwhile.
void chain_trial_take(struct chain_trial* trial, const uint8_t pushed_out[CHAIN_BYTES]);

// Where bit `place` of a stream ends up.
void chain_place(int place, int* chip, int* output, int* bit);

#endif
