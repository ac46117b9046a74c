// A real rig: the kernel's GPIO, SPI, display and cameras behind hal.h, as the rig file's linux.
// keys name them.
#ifndef LAMELLA_FIRMWARE_HAL_LINUX_H
#define LAMELLA_FIRMWARE_HAL_LINUX_H

#include "hal.h"
#include "hal_linux_actuator.h"
#include "hal_linux_camera.h"
#include "hal_linux_display.h"
#include "hal_linux_gpio.h"
#include "hal_linux_spi.h"
#include "hal_linux_thermometer.h"
#include "rig.h"

enum { LINUX_CAMERAS = 2, LINUX_MAX_SHOTS = 128, LINUX_MAX_SEEN = 512 };

// The critical outputs, by place. Those before LINUX_ANALYSER are hal_lines.
enum { LINUX_ANALYSER = HAL_LAMP + 1, LINUX_CRITICAL };
// The operator's outputs, counted from HAL_HEARTBEAT.
enum { LINUX_OPERATORS = HAL_LINES - HAL_HEARTBEAT };
enum { LINUX_START, LINUX_ESTOP, LINUX_AT_PARALLEL, LINUX_AT_CROSSED, LINUX_INPUTS };
enum { LINUX_BLANK_SEEN, LINUX_TRIGGER_SEEN, LINUX_LOOPS };

struct hal_linux {
  struct hal hal;
  const struct rig* rig;
  const char* critical_names[LINUX_CRITICAL];
  const char* operator_names[LINUX_OPERATORS];
  const char* input_names[LINUX_INPUTS];
  const char* loop_names[LINUX_LOOPS];
  struct linux_lines critical, operators, inputs, loops;
  struct linux_spi spi;
  struct linux_actuator actuator;
  struct linux_display display;
  bool has_display;
  struct linux_camera cameras[LINUX_CAMERAS];
  bool has_camera[LINUX_CAMERAS];
  struct linux_thermometer thermometer;
  int latency_fd;  // -1: none
  struct linux_shot shots[LINUX_MAX_SHOTS];
  unsigned shot_count;  // those that are over: another thread reads it, atomically
  bool triggered;
  struct hal_seen_edge seen[LINUX_MAX_SEEN];
  size_t seen_count, seen_given;
};

// Takes the lines that light hangs on, dark, and nothing else: what is held after this may be
// shared with a supervisor. LAM_BAD_INPUT where the rig file has no linux. keys.
enum lam_status hal_linux_claim(struct hal_linux* board, const struct rig* rig);

// Takes everything else, and the processor's time and locked memory (hal_linux_time.h). On failure
// nothing more than the claim is held and board->hal.error says why.
enum lam_status hal_linux_open(struct hal_linux* board);

// What the lines that light hangs on say; lit where they cannot be read.
bool hal_linux_is_lit(struct hal_linux* board);

// For a supervisor, on lines that another process left as they were: every light off and TRIGGER at
// rest, nothing else moved.
enum lam_status hal_linux_darken(struct hal_linux* board);

#endif
