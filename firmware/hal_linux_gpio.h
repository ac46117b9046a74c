// The critical output lines, in one request of the kernel. All that differs between libgpiod 1.6
// and 2 is in this module.
#ifndef LAMELLA_FIRMWARE_HAL_LINUX_GPIO_H
#define LAMELLA_FIRMWARE_HAL_LINUX_GPIO_H

#include <gpiod.h>

#include "hal.h"
#include "rig_linux.h"

enum { LINUX_GPIO_LINES = HAL_LAMP + 1 };

struct linux_gpio {
  struct gpiod_chip* chip;
#if LAMELLA_GPIOD_MAJOR == 1
  struct gpiod_line_bulk lines;
#else
  struct gpiod_line_request* request;
  unsigned offsets[LINUX_GPIO_LINES];
#endif
  int levels[LINUX_GPIO_LINES];
  char error[160];
};

// Requests the lines with BLANK at 1 and every other at 0. On LAM_HARDWARE nothing is held.
enum lam_status linux_gpio_open(struct linux_gpio* gpio, const struct rig_linux* board);

// at_us: just after the kernel has moved the line.
enum lam_status linux_gpio_set(struct linux_gpio* gpio, enum hal_line line, bool level,
                               double* at_us);

// Light off first; then the lines fall back to their pulls (BLANK's is up).
void linux_gpio_close(struct linux_gpio* gpio);

#endif
