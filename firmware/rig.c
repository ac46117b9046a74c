#include "rig.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "led_chain.h"
#include "pattern.h"
#include "rig_key.h"
#include "rig_sensor.h"

static const double kPwmSteps = 4096;

struct parser {
  struct rig* rig;
  struct rig_errors* errors;
  struct rig_given given;
};

static void take(void* context, const struct rig_pair* pair) {
  struct parser* parser = context;
  char why[160];
  if (rig_camera_knows(pair->key)) {
    const bool good = rig_camera_take(&parser->rig->sensor, pair->key, pair->value, why);
    if (!good) rig_complain(parser->errors, pair->line, "%s", why);
    return;
  }
  rig_key_take(parser->rig, &parser->given, pair, parser->errors);
}

static bool is_camera(const char* key, const char* device, char why[160]) {
  static const char* const kSources[] = {"v4l2:", "libcamera:"};  // hal_linux_camera.c
  for (size_t i = 0; i < sizeof kSources / sizeof kSources[0]; i++) {
    const size_t length = strlen(kSources[i]);
    if (strncmp(device, kSources[i], length) == 0 && device[length] != '\0') return true;
  }
  snprintf(why, 160, "'%s' is '%.60s': it must be v4l2:DEVICE or libcamera:ID", key, device);
  return false;
}

static bool are_two_cameras(const struct rig_linux* board, char why[160]) {
  if (!is_camera("linux.camera_left", board->camera_left, why)) return false;
  if (!is_camera("linux.camera_right", board->camera_right, why)) return false;
  if (strcmp(board->camera_left, board->camera_right) != 0) return true;
  snprintf(why, 160, "'linux.camera_right' is the device that 'linux.camera_left' has");
  return false;
}

// What the keys of a board's cameras say of each other and of the planner's.
static bool cameras_fit_together(const struct rig* rig, char why[160]) {
  const struct rig_camera* sensor = &rig->sensor;
  why[0] = '\0';
  const bool any = rig->board.camera_left[0] != '\0' || rig->board.camera_right[0] != '\0';
  if (!any) return true;
  if (!rig_camera_complete(sensor, why)) return false;
  const size_t bytes = raw_stored_bytes((size_t)sensor->width_px, (size_t)sensor->height_px);
  const double shortest_us = rig->leds_light_us + 2 * rig->camera_guard_us;
  if (rig->board.camera_right[0] == '\0' || rig->board.camera_left[0] == '\0') {
    snprintf(why, 160, "of 'linux.camera_left' and 'linux.camera_right' one is missing");
  } else if (!are_two_cameras(&rig->board, why)) {
    return false;
  } else if (rig->board.camera_trigger[0] == '\0') {
    snprintf(why, 160, "missing key 'linux.camera_trigger'; 'fixed' where nothing is to be set");
  } else if (rig->camera_frame_bytes != (double)bytes) {
    snprintf(why, 160, "'camera.frame_bytes' must be %zu, which width_px x height_px take", bytes);
  } else if (sensor->edge_triggered && rig_projector_light_us(rig) < shortest_us) {
    snprintf(
        why, 160,
        "'camera.trigger = edge': it exposes as long as the projector, %.0f us; LEDs need %.0f us",
        rig_projector_light_us(rig), shortest_us);
  }
  return why[0] == '\0' && rig_sensor_fits(rig, why);
}

// Light that ends within a PWM period is not what its code says.
static bool light_fits_pwm(const struct rig* rig, char why[160]) {
  const double period_us = rig_pwm_period_us(rig), periods = rig->leds_light_us / period_us;
  if (fabs(periods - round(periods)) <= 1e-4) return true;  // as safety.c has it
  snprintf(why, 160,
           "'leds.light_us' is %.6g: not a whole number of PWM periods of %.6g us "
           "(4096 / leds.gsclk_hz); %.6g or %.6g would be",
           rig->leds_light_us, period_us, floor(periods) * period_us, ceil(periods) * period_us);
  return false;
}

static bool leds_may_shine(const struct rig* rig, char why[160]) {
  const double hottest_c = rig_hottest_board_c(rig);
  if (rig->leds_ambient_c <= hottest_c) return true;
  snprintf(why, 160,
           "'leds.ambient_c' is %.4g: above %.4g C no LED may shine (leds.highest_junction_c less "
           "leds.power_w x leds.thermal_k_per_w)",
           rig->leds_ambient_c, hottest_c);
  return false;
}

enum lam_status rig_parse(const char* text, size_t length, struct rig* rig,
                          struct rig_errors* errors) {
  struct parser parser = {.rig = rig, .errors = errors};
  memset(rig, 0, sizeof *rig);
  memset(errors, 0, sizeof *errors);
  rig_key_presume(rig);
  if (!rig_text_each_pair(text, length, errors, take, &parser)) return LAM_BAD_INPUT;
  rig_key_require_all(rig, &parser.given, errors);
  // Only numbers that are right each by itself can be held against each other.
  char why[160];
  if (errors->count > 0) return LAM_BAD_INPUT;
  if (!light_fits_pwm(rig, why)) {
    rig_complain(errors, rig_key_line(&parser.given, "leds.light_us"), "%s", why);
  }
  if (!leds_may_shine(rig, why)) {
    rig_complain(errors, rig_key_line(&parser.given, "leds.ambient_c"), "%s", why);
  }
  if (!cameras_fit_together(rig, why) || !pattern_can_be_drawn(rig, why)) {
    rig_complain(errors, rig_text_line_blamed(text, length, why), "%s", why);
  }
  return errors->count == 0 ? LAM_OK : LAM_BAD_INPUT;
}

double rig_pwm_period_us(const struct rig* rig) { return kPwmSteps * 1e6 / rig->leds_gsclk_hz; }

double rig_hottest_board_c(const struct rig* rig) {
  return rig->leds_highest_junction_c - rig->leds_power_w * rig->leds_thermal_k_per_w;
}

double rig_refresh_us(const struct rig* rig) { return 1e6 / rig->projector_refresh_hz; }

double rig_projector_light_us(const struct rig* rig) {
  return rig->projector_light_periods * rig_refresh_us(rig);
}

double rig_shift_us(const struct rig* rig) { return CHAIN_BITS * 1e6 / rig->leds_spi_hz; }
