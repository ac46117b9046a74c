// The projector as a display of the kernel's (DRM/KMS, atomic): every pattern in a buffer of its
// own before the burst begins, so that a step costs one flip, which an event reports.
#ifndef LAMELLA_FIRMWARE_HAL_LINUX_DISPLAY_H
#define LAMELLA_FIRMWARE_HAL_LINUX_DISPLAY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <xf86drmMode.h>

#include "hal.h"
#include "hal_linux_output.h"
#include "pattern.h"
#include "rig.h"
#include "status.h"

struct linux_display {
  char error[160];
  int fd;  // -1 where there is none
  struct linux_output output;
  struct linux_settings settings;
  bool taken;  // the settings are in force
  uint32_t mode_blob;
  uint32_t handles[PATTERN_IMAGES], framebuffers[PATTERN_IMAGES];
  uint32_t flip_property;  // FB_ID of the plane
  size_t bytes;            // of all images
  // The flip under way, and the vblank before it.
  struct hal_pattern pattern;
  bool pending, broken;
  uint32_t sequence;
  double vblank_us;
};

// Takes linux.display_connector of linux.display_device in the projector's own mode and draws every
// image. LAM_HARDWARE, with the reason, leaves the display as it was.
enum lam_status linux_display_open(struct linux_display* display, const struct rig* rig);

// Shows the pattern from the next vblank on; returns at once. LAM_HARDWARE where a flip is still
// under way, and after a broken sequence of vblanks until linux_display_next_vblank().
enum lam_status linux_display_commit(struct linux_display* display, struct hal_pattern pattern,
                                     double* at_us);

// Once true after each commit, with the vblank's own time (CLOCK_MONOTONIC): a flip that missed its
// vblank tells the later one. Where vblanks were lost on the way it is not true, and the next
// commit fails with the reason: nobody knows what was shown then.
bool linux_display_flipped(struct linux_display* display, double* at_us);

// Returns at a vblank, from which on vblanks are counted: it comes before a burst's first flip. A
// flip under way is waited for and forgotten.
enum lam_status linux_display_next_vblank(struct linux_display* display, double* at_us);

// The display shows again what it showed before. May be called after a failed open too.
void linux_display_close(struct linux_display* display);

#endif
