// The rig file's `linux.` keys: which of the kernel's devices the rig is wired to. A rig file has
// none of them or at least all that are required; only a real board needs them. A text is empty
// where the file leaves an optional key out.
#ifndef LAMELLA_FIRMWARE_RIG_LINUX_H
#define LAMELLA_FIRMWARE_RIG_LINUX_H

#include <stdbool.h>
#include <stddef.h>

enum { RIG_DEVICE_CHARS = 64, RIG_LINUX_KEYS = 27 };

struct rig_linux {
  bool given;                        // the file has a `linux.` key
  char gpio_chip[RIG_DEVICE_CHARS];  // "/dev/gpiochip0"
  char spi_device[RIG_DEVICE_CHARS];
  // Names that the device tree gives the lines.
  char blank_line[RIG_DEVICE_CHARS], latch_line[RIG_DEVICE_CHARS];
  char trigger_line[RIG_DEVICE_CHARS], lamp_line[RIG_DEVICE_CHARS];
  char analyser_line[RIG_DEVICE_CHARS];  // 1: towards crossed
  // Optional outputs.
  char heartbeat_line[RIG_DEVICE_CHARS], ready_line[RIG_DEVICE_CHARS];
  char buzzer_line[RIG_DEVICE_CHARS];
  // Optional inputs. Loop-backs of BLANK and TRIGGER give the kernel's own time of their edges.
  char start_line[RIG_DEVICE_CHARS], estop_line[RIG_DEVICE_CHARS];
  char at_parallel_line[RIG_DEVICE_CHARS], at_crossed_line[RIG_DEVICE_CHARS];
  char blank_seen_line[RIG_DEVICE_CHARS], trigger_seen_line[RIG_DEVICE_CHARS];
  char temperature_file[RIG_DEVICE_CHARS];   // milli-degrees Celsius, as hwmon writes them
  char display_device[RIG_DEVICE_CHARS];     // "/dev/dri/card0"
  char display_connector[RIG_DEVICE_CHARS];  // "HDMI-A-1"
  char camera_left[RIG_DEVICE_CHARS];        // "v4l2:/dev/video0" or "libcamera:ID"
  char camera_right[RIG_DEVICE_CHARS];
  // Where V4L2 keeps the camera's controls, if not in its device: "/dev/v4l-subdev0".
  char camera_left_controls[RIG_DEVICE_CHARS], camera_right_controls[RIG_DEVICE_CHARS];
  char camera_trigger[RIG_DEVICE_CHARS];  // "control:NAME=VALUE", "module:NAME=VALUE" or "fixed"
  double cpu;                             // the processor that the player has to itself
  double priority;                        // of SCHED_FIFO
  double spin_us;                         // wakes this early and spins the rest
  bool seen[RIG_LINUX_KEYS];
};

// Takes one key whose name begins with "linux.". False, with a reason in `error`, where it is
// wrong.
bool rig_linux_take(struct rig_linux* board, const char* key, const char* value, char error[160]);

// The first key that is missing, or NULL where none is.
const char* rig_linux_missing(const struct rig_linux* board);

#endif
