#include "hal_linux.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "hal_linux_time.h"

static const double kPauseUs = 5000;  // to a burst's zero where no display sets it
static const double kStandEveryUs = 1000;

static enum lam_status fail(struct hal_linux* board, const char* why) {
  snprintf(board->hal.error, sizeof board->hal.error, "%s", why);
  return LAM_HARDWARE;
}

static double now_us(void* self) {
  (void)self;
  return linux_now_us();
}

static double wait_until_us(void* self, double t_us) {
  const struct hal_linux* board = self;
  return linux_wait_until_us(t_us, board->rig->board.spin_us);
}

// --- Lines ---

// What the cameras' line says to a level of HAL_TRIGGER, and the other way round.
static bool trigger_level(const struct hal_linux* board, bool level) {
  return level != board->rig->sensor.trigger_active_low;
}

// A shot is over, and another thread may ask for it, once its second edge is in its place.
static enum lam_status note_trigger(struct hal_linux* board, bool level, double at_us) {
  if (level == board->triggered) return LAM_OK;
  board->triggered = level;
  const unsigned number = __atomic_load_n(&board->shot_count, __ATOMIC_RELAXED);
  if (number == LINUX_MAX_SHOTS) return fail(board, "more shots in one burst than are counted");
  struct linux_shot* shot = &board->shots[number];
  if (level) {
    *shot = (struct linux_shot){.number = number, .trigger_us = at_us};
    return LAM_OK;
  }
  shot->untrigger_us = at_us;
  __atomic_store_n(&board->shot_count, number + 1, __ATOMIC_RELEASE);
  return LAM_OK;
}

static enum lam_status set_line(void* self, enum hal_line line, bool level, double* at_us) {
  struct hal_linux* board = self;
  if (line >= HAL_HEARTBEAT) {
    struct linux_lines* operators = &board->operators;
    const enum lam_status status = linux_outputs_set(operators, line - HAL_HEARTBEAT, level, at_us);
    return status == LAM_OK ? LAM_OK : fail(board, operators->error);
  }
  const bool driven = line == HAL_TRIGGER ? trigger_level(board, level) : level;
  const enum lam_status status = linux_outputs_set(&board->critical, line, driven, at_us);
  if (status != LAM_OK) return fail(board, board->critical.error);
  return line == HAL_TRIGGER ? note_trigger(board, level, *at_us) : LAM_OK;
}

// Each is tried, whatever became of the other.
static enum lam_status darken(struct hal_linux* board) {
  double at_us = 0;
  const enum lam_status leds = set_line(board, HAL_BLANK, true, &at_us);
  const enum lam_status lamp = set_line(board, HAL_LAMP, false, &at_us);
  const bool shut = linux_outputs_set(&board->critical, HAL_TRIGGER, trigger_level(board, false),
                                      &at_us) == LAM_OK;
  board->triggered = false;
  if (!shut) fail(board, board->critical.error);
  return leds == LAM_OK && lamp == LAM_OK && shut ? LAM_OK : LAM_HARDWARE;
}

static void lights_off(void* self) { darken(self); }

static enum lam_status shift_leds(void* self, const uint8_t stream[CHAIN_BYTES],
                                  uint8_t pushed_out[CHAIN_BYTES], double* at_us) {
  struct hal_linux* board = self;
  *at_us = linux_now_us();
  if (linux_spi_shift(&board->spi, stream, pushed_out) == LAM_OK) return LAM_OK;
  return fail(board, board->spi.error);
}

// --- Inputs ---

static enum lam_status drain_inputs(struct hal_linux* board) {
  struct linux_line_event event;
  enum lam_status status;
  while ((status = linux_inputs_next(&board->inputs, &event)) == LAM_OK) {
    if (event.place != LINUX_AT_PARALLEL && event.place != LINUX_AT_CROSSED) continue;
    linux_actuator_hear(&board->actuator, event.place == LINUX_AT_CROSSED, event.level,
                        event.at_us);
  }
  linux_actuator_look(&board->actuator, linux_now_us());
  return status == LAM_WRONG_STATE ? LAM_OK : fail(board, board->inputs.error);
}

// The kernel keeps few edges: they are taken over in the gaps of a burst.
static enum lam_status drain_loops(struct hal_linux* board) {
  struct linux_line_event event;
  while (board->seen_count < LINUX_MAX_SEEN) {
    const enum lam_status status = linux_inputs_next(&board->loops, &event);
    if (status == LAM_WRONG_STATE) break;
    if (status != LAM_OK) return fail(board, board->loops.error);
    const bool blank = event.place == LINUX_BLANK_SEEN;
    board->seen[board->seen_count++] = (struct hal_seen_edge){
        blank ? HAL_BLANK : HAL_TRIGGER, blank ? event.level : trigger_level(board, event.level),
        event.at_us};
  }
  return LAM_OK;
}

static bool next_seen(void* self, struct hal_seen_edge* edge) {
  struct hal_linux* board = self;
  drain_loops(board);
  if (board->seen_given == board->seen_count) return false;
  *edge = board->seen[board->seen_given++];
  return true;
}

static enum lam_status sense(void* self, struct hal_senses* senses) {
  struct hal_linux* board = self;
  if (drain_loops(board) != LAM_OK || drain_inputs(board) != LAM_OK) return LAM_HARDWARE;
  if (linux_lines_read(&board->inputs) != LAM_OK) return fail(board, board->inputs.error);
  if (linux_thermometer_read(&board->thermometer) != LAM_OK) {
    return fail(board, board->thermometer.error);
  }
  const int* levels = board->inputs.levels;
  *senses = (struct hal_senses){
      .start_pressed = levels[LINUX_START] == 1,
      .estopped = board->rig->board.estop_line[0] != '\0' && levels[LINUX_ESTOP] == 0,
      .at_parallel = levels[LINUX_AT_PARALLEL] == 1,
      .at_crossed = levels[LINUX_AT_CROSSED] == 1,
      .stuck = linux_actuator_is_stuck(&board->actuator, linux_now_us()),
      .hottest_c = board->thermometer.hottest_c};
  return LAM_OK;
}

// --- Actuator ---

static enum lam_status move_analyser(void* self, bool crossed, double* at_us) {
  struct hal_linux* board = self;
  const double start_us = linux_now_us();
  linux_actuator_start(&board->actuator, crossed, start_us);
  if (linux_outputs_set(&board->critical, LINUX_ANALYSER, crossed, at_us) == LAM_OK) return LAM_OK;
  return fail(board, board->critical.error);
}

static bool arrived(void* self, double* at_us) {
  struct hal_linux* board = self;
  return drain_inputs(board) == LAM_OK && linux_actuator_arrived(&board->actuator, at_us);
}

// The analyser may still be on its way from the last burst.
static enum lam_status await_rest(struct hal_linux* board) {
  struct hal_senses senses;
  do {
    if (sense(board, &senses) != LAM_OK) return LAM_HARDWARE;
    if (senses.stuck) return fail(board, HAL_STUCK);
    if (board->actuator.moving) linux_wait_until_us(linux_now_us() + kStandEveryUs, 0);
  } while (board->actuator.moving);
  if (senses.at_parallel && senses.at_crossed) {
    return fail(board,
                "both end stops say that the analyser is there: is a wire of theirs broken?");
  }
  const struct linux_actuator* actuator = &board->actuator;
  const bool there = actuator->crossed ? senses.at_crossed : senses.at_parallel;
  if (there || !actuator->has_stop[actuator->crossed]) return LAM_OK;
  return fail(board, actuator->crossed ? "the analyser is not at its crossed end stop"
                                       : "the analyser is not at its parallel end stop");
}

// --- Projector ---

static enum lam_status commit_pattern(void* self, struct hal_pattern pattern, double* at_us) {
  struct hal_linux* board = self;
  if (!board->has_display) return fail(board, "the rig file names no linux.display_device");
  if (linux_display_commit(&board->display, pattern, at_us) == LAM_OK) return LAM_OK;
  return fail(board, board->display.error);
}

static bool flipped(void* self, double* at_us) {
  struct hal_linux* board = self;
  return board->has_display && linux_display_flipped(&board->display, at_us);
}

static enum lam_status find_zero(struct hal_linux* board, double* zero_us) {
  if (board->has_display) {
    if (linux_display_next_vblank(&board->display, zero_us) == LAM_OK) return LAM_OK;
    return fail(board, board->display.error);
  }
  *zero_us = linux_now_us() + kPauseUs;
  return LAM_OK;
}

// --- Cameras ---

static enum lam_status arm_cameras(struct hal_linux* board) {
  for (size_t i = 0; i < LINUX_CAMERAS; i++) {
    struct linux_camera* camera = &board->cameras[i];
    if (!board->has_camera[i]) continue;
    camera->disarm(camera->self);
    if (camera->arm(camera->self) != LAM_OK) return fail(board, camera->error);
  }
  return LAM_OK;
}

static enum lam_status read_photograph(void* self, unsigned shot, unsigned camera,
                                       struct hal_photograph* photograph) {
  struct hal_linux* board = self;
  const char* why = NULL;
  if (camera >= LINUX_CAMERAS || !board->has_camera[camera]) {
    why = camera == 0 ? "the rig file names no linux.camera_left"
                      : "the rig file names no linux.camera_right";
  } else if (shot >= __atomic_load_n(&board->shot_count, __ATOMIC_ACQUIRE)) {
    why = "a photograph was asked for before it was taken";
  }
  if (why != NULL) {
    snprintf(photograph->error, sizeof photograph->error, "%s", why);
    return LAM_HARDWARE;
  }
  struct linux_camera* taken = &board->cameras[camera];
  return taken->read(taken->self, &board->shots[shot], photograph);
}

// --- Burst ---

static enum lam_status resume(void* self, double* zero_us) {
  struct hal_linux* board = self;
  if (darken(board) != LAM_OK || await_rest(board) != LAM_OK) return LAM_HARDWARE;
  return find_zero(board, zero_us);
}

static enum lam_status arm(void* self) {
  struct hal_linux* board = self;
  if (darken(board) != LAM_OK) return LAM_HARDWARE;
  __atomic_store_n(&board->shot_count, 0, __ATOMIC_RELEASE);
  board->triggered = false;
  struct hal_seen_edge old;
  while (next_seen(board, &old)) continue;
  board->seen_count = board->seen_given = 0;
  return arm_cameras(board);
}

static enum lam_status prepare(void* self, double* zero_us) {
  const enum lam_status armed = arm(self);
  return armed == LAM_OK ? resume(self, zero_us) : armed;
}

// --- Opening and closing ---

static void name_lines(struct hal_linux* board) {
  const struct rig_linux* rig = &board->rig->board;
  const char* const critical[LINUX_CRITICAL] = {rig->blank_line, rig->latch_line, rig->trigger_line,
                                                rig->lamp_line, rig->analyser_line};
  const char* const operators[LINUX_OPERATORS] = {rig->heartbeat_line, rig->ready_line,
                                                  rig->buzzer_line};
  const char* const inputs[LINUX_INPUTS] = {rig->start_line, rig->estop_line, rig->at_parallel_line,
                                            rig->at_crossed_line};
  const char* const loops[LINUX_LOOPS] = {rig->blank_seen_line, rig->trigger_seen_line};
  memcpy(board->critical_names, critical, sizeof critical);
  memcpy(board->operator_names, operators, sizeof operators);
  memcpy(board->input_names, inputs, sizeof inputs);
  memcpy(board->loop_names, loops, sizeof loops);
}

static void close_cameras(struct hal_linux* board) {
  for (size_t i = 0; i < LINUX_CAMERAS; i++) {
    if (board->has_camera[i]) board->cameras[i].close(board->cameras[i].self);
    board->has_camera[i] = false;
  }
}

static void close_rest(struct hal_linux* board) {
  close_cameras(board);
  if (board->has_display) linux_display_close(&board->display);
  board->has_display = false;
  linux_spi_close(&board->spi);
  linux_lines_close(&board->operators);
  linux_lines_close(&board->inputs);
  linux_lines_close(&board->loops);
  linux_thermometer_close(&board->thermometer);
  if (board->latency_fd >= 0) close(board->latency_fd);
  board->latency_fd = -1;
}

static void close_rig(void* self) {
  struct hal_linux* board = self;
  lights_off(board);
  close_rest(board);
  linux_lines_close(&board->critical);
}

static enum lam_status open_lines(struct hal_linux* board) {
  const char* chip = board->rig->board.gpio_chip;
  const int low[LINUX_OPERATORS] = {0};
  if (linux_outputs_open(&board->operators, chip, board->operator_names, low, LINUX_OPERATORS) !=
      LAM_OK) {
    return fail(board, board->operators.error);
  }
  if (linux_inputs_open(&board->inputs, chip, board->input_names, LINUX_INPUTS) != LAM_OK) {
    return fail(board, board->inputs.error);
  }
  if (linux_inputs_open(&board->loops, chip, board->loop_names, LINUX_LOOPS) != LAM_OK) {
    return fail(board, board->loops.error);
  }
  return LAM_OK;
}

static enum lam_status open_devices(struct hal_linux* board) {
  const struct rig* rig = board->rig;
  if (linux_spi_open(&board->spi, rig->board.spi_device, rig->leds_spi_hz) != LAM_OK) {
    return fail(board, board->spi.error);
  }
  if (rig->board.display_device[0] != '\0') {
    if (linux_display_open(&board->display, rig) != LAM_OK) {
      return fail(board, board->display.error);
    }
    board->has_display = true;
  }
  const char* const where[LINUX_CAMERAS] = {rig->board.camera_left, rig->board.camera_right};
  for (unsigned i = 0; i < LINUX_CAMERAS; i++) {
    if (where[i][0] == '\0') continue;
    if (linux_camera_open(&board->cameras[i], rig, i) != LAM_OK) {
      return fail(board, board->cameras[i].error);
    }
    board->has_camera[i] = true;
  }
  // A board without a camera plays its edges to the end before that is told.
  board->hal.reads_while_playing = board->has_camera[0] || board->has_camera[1];
  return LAM_OK;
}

static enum lam_status open_thermometer(struct hal_linux* board) {
  const char* file = board->rig->board.temperature_file;
  if (linux_thermometer_open(&board->thermometer, file) == LAM_OK) return LAM_OK;
  return fail(board, board->thermometer.error);
}

enum lam_status hal_linux_claim(struct hal_linux* board, const struct rig* rig) {
  memset(board, 0, sizeof *board);
  board->rig = rig;
  board->latency_fd = board->thermometer.fd = board->spi.fd = -1;
  board->hal = (struct hal){.name = "linux",
                            .self = board,
                            .keeps_real_time = true,
                            .sees_trigger = rig->board.trigger_seen_line[0] != '\0',
                            .now_us = now_us,
                            .wait_until_us = wait_until_us,
                            .prepare = prepare,
                            .arm = arm,
                            .resume = resume,
                            .set_line = set_line,
                            .shift_leds = shift_leds,
                            .commit_pattern = commit_pattern,
                            .flipped = flipped,
                            .move_analyser = move_analyser,
                            .arrived = arrived,
                            .read_photograph = read_photograph,
                            .next_seen = next_seen,
                            .sense = sense,
                            .lights_off = lights_off,
                            .close = close_rig};
  if (!rig->board.given) {
    fail(board, "the rig file has no linux. keys: it is a simulated rig's");
    return LAM_BAD_INPUT;
  }
  name_lines(board);
  linux_actuator_init(&board->actuator, rig);
  const int levels[LINUX_CRITICAL] = {[HAL_BLANK] = 1,
                                      [HAL_TRIGGER] = trigger_level(board, false),
                                      [LINUX_ANALYSER] = rig->analyser_parks_crossed};
  const enum lam_status status = linux_outputs_open(&board->critical, rig->board.gpio_chip,
                                                    board->critical_names, levels, LINUX_CRITICAL);
  return status == LAM_OK ? LAM_OK : fail(board, board->critical.error);
}

enum lam_status hal_linux_open(struct hal_linux* board) {
  enum lam_status status = open_lines(board);
  if (status == LAM_OK) status = open_devices(board);
  if (status == LAM_OK) status = open_thermometer(board);
  if (status == LAM_OK) status = linux_memory_lock(board->hal.error);
  if (status != LAM_OK) {
    close_rest(board);
    return status;
  }
  linux_time_settle(&board->rig->board, &board->latency_fd);
  board->hal.tick_us = linux_tick_us(&board->hal.tick_at_us);
  return LAM_OK;
}

bool hal_linux_is_lit(struct hal_linux* board) {
  if (linux_lines_read(&board->critical) != LAM_OK) return true;
  return board->critical.levels[HAL_BLANK] == 0 || board->critical.levels[HAL_LAMP] == 1;
}

enum lam_status hal_linux_darken(struct hal_linux* board) { return darken(board); }
