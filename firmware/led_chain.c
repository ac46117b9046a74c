#include "led_chain.h"

#include <string.h>

#include "rig.h"

void led_chain_encode(const struct rig* rig, const uint16_t codes[], uint8_t stream[CHAIN_BYTES]) {
  memset(stream, 0, CHAIN_BYTES);
  for (size_t i = 0; i < rig->led_count; i++) {
    const struct led_place* led = &rig->leds[i];
    const int first = (CHAIN_CHIPS - 1 - led->chip) * CHAIN_CHIP_BITS +
                      (CHAIN_OUTPUTS - 1 - led->output) * CHAIN_CODE_BITS;
    for (int bit = 0; bit < CHAIN_CODE_BITS; bit++) {
      const int at = first + bit;
      const unsigned value = codes[i] >> (CHAIN_CODE_BITS - 1 - bit) & 1u;
      stream[at / 8] |= (uint8_t)(value << (7 - at % 8));
    }
  }
}

// TI SBVS127E, 9.4.5.3.2 to 9.4.5.3.4, bit by bit from the last one that goes in: 0 to 167 dot
// correction, 7 an output, 127 is full; 168 to 191 brightness, 8 a colour, 255 is full; 192 to 194
// the colours' upper range of dot correction, without which full is two thirds; 195 repeats the
// period for as long as BLANK lets it; 196 a LATCH restarts the counters: BLANK does that; 197 and
// 198 how wide they are: 0 is 12 bits. 199 and up are nobody's.
void led_chain_encode_functions(uint8_t stream[CHAIN_BYTES]) {
  enum { kOnes = 196 };
  memset(stream, 0, CHAIN_BYTES);
  for (int at = 0; at < CHAIN_BITS; at++) {
    const int bit = CHAIN_CHIP_BITS - 1 - at % CHAIN_CHIP_BITS;
    if (bit < kOnes) stream[at / 8] |= (uint8_t)(0x80 >> at % 8);
  }
}
