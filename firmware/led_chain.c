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
