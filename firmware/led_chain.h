// The LED driver chain: seven 24 x 12-bit drivers, one long shift register on SPI. What goes out
// first ends farthest from the board: last chip first, output 23 first, most significant bit first.
#ifndef LAMELLA_FIRMWARE_LED_CHAIN_H
#define LAMELLA_FIRMWARE_LED_CHAIN_H

#include <stdint.h>

enum {
  CHAIN_CHIPS = 7,
  CHAIN_OUTPUTS = 24,
  CHAIN_CODE_BITS = 12,
  CHAIN_CHIP_BITS = CHAIN_OUTPUTS * CHAIN_CODE_BITS,
  CHAIN_BITS = CHAIN_CHIPS * CHAIN_CHIP_BITS,
  CHAIN_BYTES = CHAIN_BITS / 8,
  CHAIN_FULL_CODE = 4095,
  CHAIN_FUNCTION_BITS = 199,  // of each chip that has functions, from its last bit backwards
};

struct rig;

// codes[i], 0 to 4095, is LED i's greyscale code; outputs without an LED get 0.
void led_chain_encode(const struct rig* rig, const uint16_t codes[], uint8_t stream[CHAIN_BYTES]);

// What a TLC5951 must be told besides levels: full current, and 12-bit periods one after the other.
void led_chain_encode_functions(uint8_t stream[CHAIN_BYTES]);

#endif
