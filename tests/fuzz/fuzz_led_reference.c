// Any bytes as a learned LED reference, their checksum put right so that what is behind it is read
// too: taken whole and finite, or refused and not learned.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "crc32c.h"
#include "led_reference.h"

enum { kLeds = 3, kMostBytes = 1 << 16 };

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  static struct led_reference reference;
  static uint8_t copy[kMostBytes];
  if (size > sizeof copy) return 0;
  memcpy(copy, bytes, size);
  if (size > 4) {
    const uint32_t crc = crc32c_extend(0, copy, size - 4);
    for (int i = 0; i < 4; i++) copy[size - 4 + (size_t)i] = (uint8_t)(crc >> (8 * i));
  }
  if (!led_reference_parse(copy, size, kLeds, &reference)) {
    if (reference.led_count != 0) abort();
    return 0;
  }
  if (reference.led_count != kLeds) abort();
  for (int i = 0; i < kLeds; i++) {
    if (!isfinite(led_signature_norm(&reference.leds[i]))) abort();
  }
  return 0;
}
