// A TLC5951 wakes with random bits in its functions (dot correction, brightness, counter mode) as
// in its levels. They are written, and read back, before light is asked of it. A TLC5947 has none.
#ifndef LAMELLA_FIRMWARE_LED_DRIVER_H
#define LAMELLA_FIRMWARE_LED_DRIVER_H

#include "hal.h"
#include "rig.h"

// What a reading back of the functions told.
struct led_functions {
  long compared, wrong;  // bits
  int first_chip;        // from the board on, that has a wrong one; -1: none
};

// Lights off; levels zero; functions read back, and written where they are not what they should be.
// LAM_HARDWARE where the bus fails or a chip does not keep them: the reason is in hal->error.
// Leaves the chips ready for another look. Nothing is done to a chip without functions: none
// compared.
enum lam_status led_driver_ready(struct hal* hal, const struct rig* rig,
                                 struct led_functions* functions);

// Every level zero; BLANK must be 1.
enum lam_status led_driver_darken(struct hal* hal, const struct rig* rig);

#endif
