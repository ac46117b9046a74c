#include "hal_linux_gpio.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "hal_linux_time.h"

static const char kConsumer[] = "lamella-rigd";

static enum lam_status fail(struct linux_gpio* gpio, const char* what, const char* name) {
  snprintf(gpio->error, sizeof gpio->error, "%s %.60s: %s", what, name, strerror(errno));
  return LAM_HARDWARE;
}

#if LAMELLA_GPIOD_MAJOR == 1

static bool find_line(struct linux_gpio* gpio, size_t index, const char* name) {
  if (index == 0) gpiod_line_bulk_init(&gpio->lines);
  struct gpiod_line* line = gpiod_chip_find_line(gpio->chip, name);
  if (line != NULL) gpiod_line_bulk_add(&gpio->lines, line);
  return line != NULL;
}

static bool request_lines(struct linux_gpio* gpio) {
  return gpiod_line_request_bulk_output(&gpio->lines, kConsumer, gpio->levels) == 0;
}

// Every line each time: this library sets the lines of a request that one does not name to 0, and
// BLANK at 0 is light.
static bool apply(struct linux_gpio* gpio, enum hal_line line) {
  (void)line;
  return gpiod_line_set_value_bulk(&gpio->lines, gpio->levels) == 0;
}

static void release(struct linux_gpio* gpio) { gpiod_line_release_bulk(&gpio->lines); }

#else

static bool find_line(struct linux_gpio* gpio, size_t index, const char* name) {
  const int offset = gpiod_chip_get_line_offset_from_name(gpio->chip, name);
  if (offset >= 0) gpio->offsets[index] = (unsigned)offset;
  return offset >= 0;
}

static enum gpiod_line_value value_of(int level) {
  return level ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
}

static bool configure(const struct linux_gpio* gpio, struct gpiod_line_settings* settings,
                      struct gpiod_line_config* lines) {
  if (gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_OUTPUT) != 0) return false;
  for (size_t i = 0; i < LINUX_GPIO_LINES; i++) {
    if (gpiod_line_settings_set_output_value(settings, value_of(gpio->levels[i])) != 0 ||
        gpiod_line_config_add_line_settings(lines, &gpio->offsets[i], 1, settings) != 0) {
      return false;
    }
  }
  return true;
}

static bool request_lines(struct linux_gpio* gpio) {
  struct gpiod_line_settings* settings = gpiod_line_settings_new();
  struct gpiod_line_config* lines = gpiod_line_config_new();
  struct gpiod_request_config* request = gpiod_request_config_new();
  gpio->request = NULL;
  if (settings != NULL && lines != NULL && request != NULL && configure(gpio, settings, lines)) {
    gpiod_request_config_set_consumer(request, kConsumer);
    gpio->request = gpiod_chip_request_lines(gpio->chip, request, lines);
  }
  gpiod_request_config_free(request);
  gpiod_line_config_free(lines);
  gpiod_line_settings_free(settings);
  return gpio->request != NULL;
}

static bool apply(struct linux_gpio* gpio, enum hal_line line) {
  return gpiod_line_request_set_value(gpio->request, gpio->offsets[line],
                                      value_of(gpio->levels[line])) == 0;
}

static void release(struct linux_gpio* gpio) { gpiod_line_request_release(gpio->request); }

#endif

static enum lam_status acquire(struct linux_gpio* gpio, const struct rig_linux* board) {
  const char* const names[LINUX_GPIO_LINES] = {[HAL_BLANK] = board->blank_line,
                                               [HAL_LATCH] = board->latch_line,
                                               [HAL_TRIGGER] = board->trigger_line,
                                               [HAL_LAMP] = board->lamp_line};
  for (size_t i = 0; i < LINUX_GPIO_LINES; i++) {
    errno = ENOENT;
    if (!find_line(gpio, i, names[i])) return fail(gpio, "no GPIO line", names[i]);
  }
  gpio->levels[HAL_BLANK] = 1;
  return request_lines(gpio) ? LAM_OK : fail(gpio, "cannot drive the lines of", board->gpio_chip);
}

enum lam_status linux_gpio_open(struct linux_gpio* gpio, const struct rig_linux* board) {
  memset(gpio, 0, sizeof *gpio);
  gpio->chip = gpiod_chip_open(board->gpio_chip);
  if (gpio->chip == NULL) return fail(gpio, "cannot open", board->gpio_chip);
  const enum lam_status status = acquire(gpio, board);
  if (status != LAM_OK) gpiod_chip_close(gpio->chip);
  return status;
}

enum lam_status linux_gpio_set(struct linux_gpio* gpio, enum hal_line line, bool level,
                               double* at_us) {
  gpio->levels[line] = level;
  const bool moved = apply(gpio, line);
  *at_us = linux_now_us();
  return moved ? LAM_OK : fail(gpio, "cannot set", "a GPIO line");
}

void linux_gpio_close(struct linux_gpio* gpio) {
  gpio->levels[HAL_BLANK] = 1;
  apply(gpio, HAL_BLANK);
  release(gpio);
  gpiod_chip_close(gpio->chip);
}
