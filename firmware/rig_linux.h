// The rig file's `linux.` keys: which of the kernel's devices the rig is wired to. A rig file has
// all of them or none; only a real board needs them.
#ifndef LAMELLA_FIRMWARE_RIG_LINUX_H
#define LAMELLA_FIRMWARE_RIG_LINUX_H

#include <stdbool.h>
#include <stddef.h>

enum { RIG_DEVICE_CHARS = 64, RIG_LINUX_KEYS = 9 };

struct rig_linux {
  bool given;                        // the file has a `linux.` key
  char gpio_chip[RIG_DEVICE_CHARS];  // "/dev/gpiochip0"
  char spi_device[RIG_DEVICE_CHARS];
  // Names that the device tree gives the lines.
  char blank_line[RIG_DEVICE_CHARS], latch_line[RIG_DEVICE_CHARS];
  char trigger_line[RIG_DEVICE_CHARS], lamp_line[RIG_DEVICE_CHARS];
  double cpu;       // the processor that the player has to itself
  double priority;  // of SCHED_FIFO
  double spin_us;   // wakes this early and spins the rest
  bool seen[RIG_LINUX_KEYS];
};

// Takes one key whose name begins with "linux.". False, with a reason in `error`, where it is
// wrong.
bool rig_linux_take(struct rig_linux* board, const char* key, const char* value, char error[160]);

// The first key that is missing, or NULL where none is.
const char* rig_linux_missing(const struct rig_linux* board);

#endif
