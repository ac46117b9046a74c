#include "led_driver.h"

#include <stdio.h>

#include "led_chain.h"

static const uint8_t kDark[CHAIN_BYTES];

static enum lam_status latch(struct hal* hal, const struct rig* rig, bool level) {
  double at_us = 0;
  const enum lam_status status = hal->set_line(hal->self, HAL_LATCH, level, &at_us);
  hal->wait_until_us(hal->self, at_us + rig->leds_latch_us);
  return status;
}

static enum lam_status shift(struct hal* hal, const uint8_t* stream, uint8_t* pushed_out) {
  double at_us = 0;
  return hal->shift_leds(hal->self, stream, pushed_out, &at_us);
}

// Zeros as levels. The rising edge also puts the functions into the shift register, from where the
// next frame pushes them out (TI SBVS127E, 9.4.6 Status Information Data).
static enum lam_status darken(struct hal* hal, const struct rig* rig, uint8_t* pushed_out) {
  if (shift(hal, kDark, pushed_out) != LAM_OK || latch(hal, rig, true) != LAM_OK) {
    return LAM_HARDWARE;
  }
  return latch(hal, rig, false);
}

enum lam_status led_driver_darken(struct hal* hal, const struct rig* rig) {
  return darken(hal, rig, NULL);
}

// Bits that are clocked in while LATCH is high are functions at its next rising edge, and levels
// otherwise (9.4.5.1 288-Bit Common Shift Register). LATCH must rise once for that alone: with
// zeros in the register, that no garbage becomes levels.
static enum lam_status write_functions(struct hal* hal, const struct rig* rig) {
  uint8_t stream[CHAIN_BYTES];
  led_chain_encode_functions(stream);
  if (shift(hal, kDark, NULL) != LAM_OK || latch(hal, rig, true) != LAM_OK ||
      shift(hal, stream, NULL) != LAM_OK || latch(hal, rig, false) != LAM_OK ||
      latch(hal, rig, true) != LAM_OK) {
    return LAM_HARDWARE;
  }
  return latch(hal, rig, false);
}

static void compare(const uint8_t out[CHAIN_BYTES], struct led_functions* functions) {
  uint8_t right[CHAIN_BYTES];
  led_chain_encode_functions(right);
  *functions = (struct led_functions){.first_chip = -1};
  for (int at = 0; at < CHAIN_BITS; at++) {
    if (CHAIN_CHIP_BITS - 1 - at % CHAIN_CHIP_BITS >= CHAIN_FUNCTION_BITS) continue;
    functions->compared++;
    if (((out[at / 8] ^ right[at / 8]) >> (7 - at % 8) & 1) == 0) continue;
    functions->wrong++;
    functions->first_chip = CHAIN_CHIPS - 1 - at / CHAIN_CHIP_BITS;
  }
}

static enum lam_status look(struct hal* hal, const struct rig* rig,
                            struct led_functions* functions) {
  uint8_t out[CHAIN_BYTES];
  if (darken(hal, rig, out) != LAM_OK) return LAM_HARDWARE;
  compare(out, functions);
  return LAM_OK;
}

// LATCH may still be high where a program before this one was killed.
enum lam_status led_driver_ready(struct hal* hal, const struct rig* rig,
                                 struct led_functions* functions) {
  *functions = (struct led_functions){.first_chip = -1};
  hal->lights_off(hal->self);
  if (!rig->leds_have_functions) return LAM_OK;
  if (latch(hal, rig, false) != LAM_OK || look(hal, rig, functions) != LAM_OK) return LAM_HARDWARE;
  if (functions->wrong == 0) return LAM_OK;
  if (write_functions(hal, rig) != LAM_OK || led_driver_darken(hal, rig) != LAM_OK ||
      look(hal, rig, functions) != LAM_OK) {
    return LAM_HARDWARE;
  }
  if (functions->wrong == 0) return LAM_OK;
  snprintf(hal->error, sizeof hal->error,
           "LED driver chip %d does not keep its functions (%ld of %ld bits are wrong): check its "
           "supply and LATCH, or by lamella rig selftest --only chain that none is missing",
           functions->first_chip, functions->wrong, functions->compared);
  return LAM_HARDWARE;
}
