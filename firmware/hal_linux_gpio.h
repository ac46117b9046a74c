// GPIO lines in requests of the kernel, found by the names that the device tree gives them. All
// that differs between libgpiod 1.6 and 2 is in this module.
#ifndef LAMELLA_FIRMWARE_HAL_LINUX_GPIO_H
#define LAMELLA_FIRMWARE_HAL_LINUX_GPIO_H

#include <gpiod.h>
#include <stdbool.h>
#include <stddef.h>

#include "status.h"

enum { LINUX_LINES_MAX = 8 };

// Lines that belong together, by their place in `names`; an empty name is a line that the rig has
// not: setting it does nothing, it reads 0 and never has an edge.
struct linux_lines {
  struct gpiod_chip* chip;  // NULL: nothing is held
  const char* const* names;
  size_t count;
  int levels[LINUX_LINES_MAX];  // as last set or read, by place
  bool outputs;
  size_t held;  // lines that are requested
  size_t place_of[LINUX_LINES_MAX];
#if LAMELLA_GPIOD_MAJOR == 1
  struct gpiod_line_bulk lines;
  struct gpiod_line* line_of[LINUX_LINES_MAX];  // by place
#else
  struct gpiod_line_request* request;
  struct gpiod_edge_event_buffer* events;
  unsigned offset_of[LINUX_LINES_MAX];  // by place
#endif
  char error[160];
};

struct linux_line_event {
  size_t place;
  bool level;
  double at_us;  // the kernel's own, CLOCK_MONOTONIC
};

// Drives the lines, from `levels` on: nothing else is ever driven, not even for a moment.
// `names` outlives the lines. On LAM_HARDWARE nothing is held, and `error` says why.
enum lam_status linux_outputs_open(struct linux_lines* lines, const char* chip,
                                   const char* const names[], const int levels[], size_t count);
// Pulls are the board's own. Both edges of every line are remembered by the kernel.
enum lam_status linux_inputs_open(struct linux_lines* lines, const char* chip,
                                  const char* const names[], size_t count);

// Moves one line and no other. at_us: just after the kernel has moved it.
enum lam_status linux_outputs_set(struct linux_lines* outputs, size_t place, bool level,
                                  double* at_us);

// Reads every line, input or output, into `levels`.
enum lam_status linux_lines_read(struct linux_lines* lines);
// The oldest edge of some line that was not asked for yet; LAM_WRONG_STATE where there is none.
enum lam_status linux_inputs_next(struct linux_lines* inputs, struct linux_line_event* event);

// Outputs fall back to their pulls. Harmless where nothing is held.
void linux_lines_close(struct linux_lines* lines);

#endif
