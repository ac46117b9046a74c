// The way to one projector through the kernel's mode setting: its connector, a CRTC, that CRTC's
// primary plane and the projector's own mode; and every property that is set on them.
#ifndef LAMELLA_FIRMWARE_HAL_LINUX_OUTPUT_H
#define LAMELLA_FIRMWARE_HAL_LINUX_OUTPUT_H

#include <stddef.h>
#include <xf86drmMode.h>

#include "rig.h"
#include "status.h"

struct linux_output {
  uint32_t connector, crtc, plane;
  unsigned pipe;         // the CRTC's number: vblanks are asked for by it
  drmModeModeInfo mode;  // of the projector's own pixels
  double refresh_us;
};

// A property that is set, and what it was before.
struct linux_setting {
  uint32_t object, property, before_blob;
  uint64_t now, before;
};

enum { LINUX_MOST_SETTINGS = 64 };
struct linux_settings {
  struct linux_setting list[LINUX_MOST_SETTINGS];
  size_t count;
};

// Finds the way to linux.display_connector. LAM_HARDWARE, with the reason, where it is not there,
// where its own pixels are not projector.width_px x projector.height_px or where no mode of that
// size refreshes at projector.refresh_hz: a burst counts in refreshes.
enum lam_status linux_output_find(int fd, const struct rig* rig, struct linux_output* output,
                                  char error[160]);

// Everything that shows framebuffer `fb`, whole and unscaled, with codes as they are: full range, 8
// bits, no table of colours, nothing else over it. What was before is remembered.
enum lam_status linux_output_settings(int fd, const struct linux_output* output,
                                      const uint32_t mode_blob_and_fb[2],
                                      struct linux_settings* settings, char error[160]);

// Sets all of them, or (`back`) what they were; 0, or an error number.
int linux_settings_commit(int fd, const struct linux_settings* settings, bool back);
void linux_settings_forget(int fd, struct linux_settings* settings);

#endif
