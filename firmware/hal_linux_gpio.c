#include "hal_linux_gpio.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "hal_linux_time.h"

static const char kConsumer[] = "lamella-rigd";

static enum lam_status fail(struct linux_lines* lines, const char* what, const char* name) {
  snprintf(lines->error, sizeof lines->error, "%s %.60s: %s", what, name, strerror(errno));
  return LAM_HARDWARE;
}

// Each of these is written once for libgpiod 1.6 and once for 2; below them nothing differs.
static bool find_line(struct linux_lines* lines, size_t place);
static bool request_lines(struct linux_lines* lines);
static bool drive(struct linux_lines* lines, size_t place);
static bool read_levels(struct linux_lines* lines, int levels[LINUX_LINES_MAX]);
static int wait_event(struct linux_lines* lines,
                      struct linux_line_event* event);  // 1: there is one
static void release(struct linux_lines* lines);

#if LAMELLA_GPIOD_MAJOR == 1

static bool find_line(struct linux_lines* lines, size_t place) {
  if (lines->held == 0) gpiod_line_bulk_init(&lines->lines);
  struct gpiod_line* line = gpiod_chip_find_line(lines->chip, lines->names[place]);
  if (line != NULL) gpiod_line_bulk_add(&lines->lines, line);
  lines->line_of[place] = line;
  return line != NULL;
}

// This library sets all lines of a request at once: each output has a request of its own, so that
// an edge costs one line's time, and no line is ever set for another's sake.
static bool request_lines(struct linux_lines* lines) {
  if (!lines->outputs) {
    return gpiod_line_request_bulk_both_edges_events(&lines->lines, kConsumer) == 0;
  }
  for (size_t i = 0; i < lines->held; i++) {
    const size_t place = lines->place_of[i];
    struct gpiod_line* line = lines->line_of[place];
    if (gpiod_line_request_output(line, kConsumer, lines->levels[place]) == 0) continue;
    const int reason = errno;
    gpiod_line_release_bulk(&lines->lines);
    errno = reason;
    return false;
  }
  return true;
}

static bool drive(struct linux_lines* lines, size_t place) {
  return gpiod_line_set_value(lines->line_of[place], lines->levels[place]) == 0;
}

static bool read_levels(struct linux_lines* lines, int levels[LINUX_LINES_MAX]) {
  for (size_t i = 0; i < lines->held; i++) {
    levels[i] = gpiod_line_get_value(lines->line_of[lines->place_of[i]]);
    if (levels[i] < 0) return false;
  }
  return true;
}

static int wait_event(struct linux_lines* lines, struct linux_line_event* event) {
  const struct timespec now = {0, 0};
  struct gpiod_line_bulk ready;
  const int some = gpiod_line_event_wait_bulk(&lines->lines, &now, &ready);
  if (some <= 0) return some;
  struct gpiod_line* line = gpiod_line_bulk_get_line(&ready, 0);
  struct gpiod_line_event read;
  if (gpiod_line_event_read(line, &read) != 0) return -1;
  for (size_t i = 0; i < lines->held; i++) {
    if (lines->line_of[lines->place_of[i]] == line) event->place = lines->place_of[i];
  }
  event->level = read.event_type == GPIOD_LINE_EVENT_RISING_EDGE;
  event->at_us = (double)read.ts.tv_sec * 1e6 + (double)read.ts.tv_nsec * 1e-3;
  return 1;
}

static void release(struct linux_lines* lines) { gpiod_line_release_bulk(&lines->lines); }

#else

static bool find_line(struct linux_lines* lines, size_t place) {
  const int offset = gpiod_chip_get_line_offset_from_name(lines->chip, lines->names[place]);
  if (offset >= 0) lines->offset_of[place] = (unsigned)offset;
  return offset >= 0;
}

static enum gpiod_line_value value_of(int level) {
  return level ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
}

static bool set_direction(const struct linux_lines* lines, struct gpiod_line_settings* settings) {
  if (lines->outputs) {
    return gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_OUTPUT) == 0;
  }
  return gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_INPUT) == 0 &&
         gpiod_line_settings_set_edge_detection(settings, GPIOD_LINE_EDGE_BOTH) == 0 &&
         gpiod_line_settings_set_event_clock(settings, GPIOD_LINE_CLOCK_MONOTONIC) == 0;
}

static bool configure(const struct linux_lines* lines, struct gpiod_line_settings* settings,
                      struct gpiod_line_config* config) {
  if (!set_direction(lines, settings)) return false;
  for (size_t i = 0; i < lines->held; i++) {
    const size_t place = lines->place_of[i];
    const enum gpiod_line_value value = value_of(lines->levels[place]);
    if ((lines->outputs && gpiod_line_settings_set_output_value(settings, value) != 0) ||
        gpiod_line_config_add_line_settings(config, &lines->offset_of[place], 1, settings) != 0) {
      return false;
    }
  }
  return true;
}

static bool request_lines(struct linux_lines* lines) {
  enum { kEventsKept = 256 };  // more edges than a burst has
  struct gpiod_line_settings* settings = gpiod_line_settings_new();
  struct gpiod_line_config* config = gpiod_line_config_new();
  struct gpiod_request_config* request = gpiod_request_config_new();
  lines->request = NULL;
  lines->events = gpiod_edge_event_buffer_new(1);
  if (settings != NULL && config != NULL && request != NULL && lines->events != NULL &&
      configure(lines, settings, config)) {
    gpiod_request_config_set_consumer(request, kConsumer);
    gpiod_request_config_set_event_buffer_size(request, kEventsKept);
    lines->request = gpiod_chip_request_lines(lines->chip, request, config);
  }
  const int reason = errno;
  if (lines->request == NULL && lines->events != NULL) gpiod_edge_event_buffer_free(lines->events);
  gpiod_request_config_free(request);
  gpiod_line_config_free(config);
  gpiod_line_settings_free(settings);
  errno = reason;
  return lines->request != NULL;
}

static bool drive(struct linux_lines* lines, size_t place) {
  return gpiod_line_request_set_value(lines->request, lines->offset_of[place],
                                      value_of(lines->levels[place])) == 0;
}

static bool read_levels(struct linux_lines* lines, int levels[LINUX_LINES_MAX]) {
  enum gpiod_line_value values[LINUX_LINES_MAX];
  if (gpiod_line_request_get_values(lines->request, values) != 0) return false;
  for (size_t i = 0; i < lines->held; i++) levels[i] = values[i] == GPIOD_LINE_VALUE_ACTIVE;
  return true;
}

static int wait_event(struct linux_lines* lines, struct linux_line_event* event) {
  const int some = gpiod_line_request_wait_edge_events(lines->request, 0);
  if (some <= 0) return some;
  if (gpiod_line_request_read_edge_events(lines->request, lines->events, 1) != 1) return -1;
  struct gpiod_edge_event* read = gpiod_edge_event_buffer_get_event(lines->events, 0);
  const unsigned offset = gpiod_edge_event_get_line_offset(read);
  for (size_t i = 0; i < lines->held; i++) {
    if (lines->offset_of[lines->place_of[i]] == offset) event->place = lines->place_of[i];
  }
  event->level = gpiod_edge_event_get_event_type(read) == GPIOD_EDGE_EVENT_RISING_EDGE;
  event->at_us = (double)gpiod_edge_event_get_timestamp_ns(read) * 1e-3;
  return 1;
}

static void release(struct linux_lines* lines) {
  gpiod_line_request_release(lines->request);
  gpiod_edge_event_buffer_free(lines->events);
}

#endif

static enum lam_status find_lines(struct linux_lines* lines) {
  for (size_t place = 0; place < lines->count; place++) {
    if (lines->names[place][0] == '\0') continue;
    errno = ENOENT;
    if (!find_line(lines, place)) {
      return fail(lines, "no GPIO line", lines->names[place]);
    }
    lines->place_of[lines->held++] = place;
  }
  return LAM_OK;
}

static enum lam_status open_lines(struct linux_lines* lines, const char* chip) {
  lines->chip = gpiod_chip_open(chip);
  if (lines->chip == NULL) return fail(lines, "cannot open", chip);
  enum lam_status status = find_lines(lines);
  if (status == LAM_OK && lines->held > 0 && !request_lines(lines)) {
    status = fail(lines, lines->outputs ? "cannot drive" : "cannot watch", lines->names[0]);
  }
  if (status == LAM_OK && lines->held > 0) return LAM_OK;
  gpiod_chip_close(lines->chip);
  lines->chip = NULL;
  return status;
}

enum lam_status linux_outputs_open(struct linux_lines* lines, const char* chip,
                                   const char* const names[], const int levels[], size_t count) {
  *lines = (struct linux_lines){.names = names, .count = count, .outputs = true};
  memcpy(lines->levels, levels, count * sizeof levels[0]);
  return open_lines(lines, chip);
}

enum lam_status linux_inputs_open(struct linux_lines* lines, const char* chip,
                                  const char* const names[], size_t count) {
  *lines = (struct linux_lines){.names = names, .count = count};
  return open_lines(lines, chip);
}

enum lam_status linux_outputs_set(struct linux_lines* outputs, size_t place, bool level,
                                  double* at_us) {
  outputs->levels[place] = level;
  const bool idle = outputs->chip == NULL || outputs->names[place][0] == '\0';
  const bool moved = idle || drive(outputs, place);
  *at_us = linux_now_us();
  return moved ? LAM_OK : fail(outputs, "cannot set GPIO line", outputs->names[place]);
}

enum lam_status linux_lines_read(struct linux_lines* lines) {
  if (lines->chip == NULL) return LAM_OK;
  int levels[LINUX_LINES_MAX];
  if (!read_levels(lines, levels)) return fail(lines, "cannot read GPIO line", lines->names[0]);
  for (size_t i = 0; i < lines->held; i++) lines->levels[lines->place_of[i]] = levels[i];
  return LAM_OK;
}

enum lam_status linux_inputs_next(struct linux_lines* inputs, struct linux_line_event* event) {
  const int some = inputs->chip == NULL ? 0 : wait_event(inputs, event);
  if (some > 0) return LAM_OK;
  return some == 0 ? LAM_WRONG_STATE
                   : fail(inputs, "cannot hear GPIO lines such as", inputs->names[0]);
}

void linux_lines_close(struct linux_lines* lines) {
  if (lines->chip == NULL) return;
  release(lines);
  gpiod_chip_close(lines->chip);
  lines->chip = NULL;
}
