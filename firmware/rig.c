#include "rig.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "led_chain.h"
#include "pattern.h"

enum { kMaxLineBytes = 160 };
static const double kPwmSteps = 4096;

// A number of the rig file: where it goes and what it may be.
struct number_key {
  const char* name;
  size_t offset;
  double lowest, highest;
};

#define NUMBER(name, field, lowest, highest) \
  { name, offsetof(struct rig, field), lowest, highest }
static const struct number_key kNumbers[] = {
    NUMBER("leds.spi_hz", leds_spi_hz, 1e5, 15e6),
    NUMBER("leds.gsclk_hz", leds_gsclk_hz, 1e5, 33e6),
    NUMBER("leds.light_us", leds_light_us, 100, 1e6),
    NUMBER("leds.latch_us", leds_latch_us, 0.1, 1000),
    NUMBER("leds.longest_on_us", leds_longest_on_us, 100, 1e6),
    NUMBER("leds.duty_window_us", leds_duty_window_us, 1e3, 60e6),
    NUMBER("leds.highest_duty", leds_highest_duty, 0.01, 1),
    NUMBER("leds.power_w", leds_power_w, 0.001, 100),
    NUMBER("leds.thermal_k_per_w", leds_thermal_k_per_w, 0.1, 1000),
    NUMBER("leds.thermal_time_us", leds_thermal_time_us, 1e3, 3600e6),
    NUMBER("leds.ambient_c", leds_ambient_c, -20, 80),
    NUMBER("leds.highest_junction_c", leds_highest_junction_c, 30, 200),
    NUMBER("camera.start_delay_us", camera_start_delay_us, 0, 1e5),
    NUMBER("camera.guard_us", camera_guard_us, 1, 1e5),
    NUMBER("camera.readout_us", camera_readout_us, 0, 1e6),
    NUMBER("camera.frame_bytes", camera_frame_bytes, 1, 1e9),
    NUMBER("camera.f_number", camera_f_number, 0.5, 64),
    NUMBER("camera.iso", camera_iso, 1, 1e6),
    NUMBER("camera.analyser_transmission", camera_analyser_transmission, 0.01, 1),
    NUMBER("analyser.move_us", analyser_move_us, 1, 5e6),
    NUMBER("analyser.settle_us", analyser_settle_us, 0, 5e6),
    NUMBER("projector.refresh_hz", projector_refresh_hz, 10, 1000),
    NUMBER("projector.light_periods", projector_light_periods, 1, 100),
    NUMBER("projector.latency_us", projector_latency_us, 0, 5e5),
    NUMBER("projector.settle_us", projector_settle_us, 0, 5e5),
    NUMBER("projector.commit_lead_us", projector_commit_lead_us, 0, 1e5),
    NUMBER("projector.lamp_settle_us", projector_lamp_settle_us, 0, 5e6),
    NUMBER("projector.width_px", projector_width_px, 16, RIG_MOST_PROJECTOR_PX),
    NUMBER("projector.height_px", projector_height_px, 16, RIG_MOST_PROJECTOR_PX),
    NUMBER("projector.gamma", projector_gamma, 0.5, 4),
    NUMBER("pattern.fringe_0_periods", pattern_fringe_periods[0], 0.1, 2048),
    NUMBER("pattern.fringe_1_periods", pattern_fringe_periods[1], 0.1, 2048),
    NUMBER("pattern.fringe_2_periods", pattern_fringe_periods[2], 0.1, 2048),
    NUMBER("pattern.fringe_3_periods", pattern_fringe_periods[3], 0.1, 2048),
    NUMBER("pattern.stripe_period_px", pattern_stripe_period_px, 2, 4096),
    NUMBER("pattern.stripe_shift_px", pattern_stripe_shift_px, 0.01, 2048),
    NUMBER("pattern.dot_pitch_px", pattern_dot_pitch_px, 4, 4096),
    NUMBER("pattern.dot_diameter_px", pattern_dot_diameter_px, 1, 4096),
    NUMBER("pattern.dot_offset_u_px", pattern_dot_offset_u_px, -4096, 4096),
    NUMBER("pattern.dot_offset_v_px", pattern_dot_offset_v_px, -4096, 4096),
    NUMBER("player.critical_tolerance_us", player_critical_tolerance_us, 1, 1e5),
    NUMBER("player.tolerance_us", player_tolerance_us, 1, 1e6),
    NUMBER("burst.pair_weight", burst_pair_weight, 0, 1000),
    NUMBER("burst.longest_us", burst_longest_us, 1e4, 60e6),
    NUMBER("store.capacity_bytes", store_capacity_bytes, 1 << 20, 17179869184.0),
    NUMBER("store.disk_bytes_per_s", store_disk_bytes_per_s, 0, 1e11),
    NUMBER("light.leds_lux", light_leds_lux, 0.1, 1e7),
    NUMBER("light.projector_lux", light_projector_lux, 0.1, 1e7),
    NUMBER("light.least_share", light_least_share, 0, 1),
};
enum { kNumberCount = sizeof kNumbers / sizeof kNumbers[0] };

// A key with two words to choose from.
struct choice_key {
  const char* name;
  size_t offset;
  const char *no, *yes;
};

static const struct choice_key kChoices[] = {
    {"analyser.park", offsetof(struct rig, analyser_parks_crossed), "parallel", "crossed"},
    {"camera.readout_overlaps", offsetof(struct rig, camera_readout_overlaps), "no", "yes"},
};
enum { kChoiceCount = sizeof kChoices / sizeof kChoices[0] };

struct parser {
  struct rig* rig;
  struct rig_error* error;
  int line;
  bool number_seen[kNumberCount];
  bool choice_seen[kChoiceCount];
  bool output_used[CHAIN_CHIPS][CHAIN_OUTPUTS];
};

static enum lam_status fail(struct parser* parser, int line, const char* format, ...) {
  parser->error->line = line;
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(parser->error->text, sizeof parser->error->text, format, arguments);
  va_end(arguments);
  return LAM_BAD_INPUT;
}

static enum lam_status parse_number(struct parser* parser, size_t index, const char* value) {
  const struct number_key* key = &kNumbers[index];
  if (parser->number_seen[index]) {
    return fail(parser, parser->line, "'%s' is given twice", key->name);
  }
  parser->number_seen[index] = true;
  char* end = NULL;
  const double number = strtod(value, &end);
  if (end == value || *end != '\0') {
    return fail(parser, parser->line, "'%s' needs one number, not '%.40s'", key->name, value);
  }
  if (!(number >= key->lowest && number <= key->highest)) {
    return fail(parser, parser->line, "'%s' is %.10g; it must be between %.10g and %.10g",
                key->name, number, key->lowest, key->highest);
  }
  *(double*)((char*)parser->rig + key->offset) = number;
  return LAM_OK;
}

static enum lam_status parse_choice(struct parser* parser, size_t index, const char* value) {
  const struct choice_key* key = &kChoices[index];
  if (parser->choice_seen[index]) {
    return fail(parser, parser->line, "'%s' is given twice", key->name);
  }
  parser->choice_seen[index] = true;
  const bool yes = strcmp(value, key->yes) == 0;
  if (!yes && strcmp(value, key->no) != 0) {
    return fail(parser, parser->line, "'%s' is %s or %s, not '%.40s'", key->name, key->no, key->yes,
                value);
  }
  *(bool*)((char*)parser->rig + key->offset) = yes;
  return LAM_OK;
}

static enum lam_status check_led(struct parser* parser, const char* key, long chip, long output) {
  const double* d = parser->rig->leds[parser->rig->led_count].direction;
  if (chip < 0 || chip >= CHAIN_CHIPS || output < 0 || output >= CHAIN_OUTPUTS) {
    return fail(parser, parser->line,
                "'%s' is at chip %ld output %ld; chips are 0 to %d, outputs "
                "0 to %d",
                key, chip, output, CHAIN_CHIPS - 1, CHAIN_OUTPUTS - 1);
  }
  if (parser->output_used[chip][output]) {
    return fail(parser, parser->line, "'%s' is at chip %ld output %ld, which another LED has", key,
                chip, output);
  }
  if (!(fabs(sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) - 1) < 1e-3)) {
    return fail(parser, parser->line, "'%s' has a direction whose length is not 1", key);
  }
  parser->output_used[chip][output] = true;
  return LAM_OK;
}

// `led.N = chip output x y z`, N counting from 0 without a gap.
static enum lam_status parse_led(struct parser* parser, const char* key, const char* value) {
  struct rig* rig = parser->rig;
  char expected[24];
  snprintf(expected, sizeof expected, "led.%zu", rig->led_count);
  if (strcmp(key, expected) != 0 || rig->led_count == RIG_MAX_LEDS) {
    return fail(parser, parser->line, "'%.40s' stands where '%s' is due (at most %d LEDs)", key,
                expected, RIG_MAX_LEDS);
  }
  struct led_place* led = &rig->leds[rig->led_count];
  int chip = -1, output = -1, used = 0;
  const int count = sscanf(value, "%4d %4d %lf %lf %lf %n", &chip, &output, &led->direction[0],
                           &led->direction[1], &led->direction[2], &used);
  if (count != 5 || value[used] != '\0') {
    return fail(parser, parser->line, "'%s' needs chip, output, x, y, z", key);
  }
  const enum lam_status status = check_led(parser, key, chip, output);
  led->chip = (uint8_t)chip;
  led->output = (uint8_t)output;
  rig->led_count++;
  return status;
}

static enum lam_status parse_pair(struct parser* parser, const char* key, const char* value) {
  if (strncmp(key, "led.", 4) == 0) return parse_led(parser, key, value);
  if (strncmp(key, "linux.", 6) == 0) {
    parser->error->line = parser->line;
    return rig_linux_take(&parser->rig->board, key, value, parser->error->text) ? LAM_OK
                                                                                : LAM_BAD_INPUT;
  }
  if (rig_camera_knows(key)) {
    parser->error->line = parser->line;
    return rig_camera_take(&parser->rig->sensor, key, value, parser->error->text) ? LAM_OK
                                                                                  : LAM_BAD_INPUT;
  }
  for (size_t i = 0; i < kChoiceCount; i++) {
    if (strcmp(key, kChoices[i].name) == 0) return parse_choice(parser, i, value);
  }
  for (size_t i = 0; i < kNumberCount; i++) {
    if (strcmp(key, kNumbers[i].name) == 0) return parse_number(parser, i, value);
  }
  return fail(parser, parser->line, "unknown key '%.40s'", key);
}

static char* trim(char* text) {
  static const char kBlank[] = " \t\r";
  text += strspn(text, kBlank);
  size_t length = strlen(text);
  while (length > 0 && strchr(kBlank, text[length - 1]) != NULL) text[--length] = '\0';
  return text;
}

static enum lam_status parse_line(struct parser* parser, char* line) {
  line[strcspn(line, "#")] = '\0';
  char* key = trim(line);
  if (*key == '\0') return LAM_OK;
  char* equals = strchr(key, '=');
  if (equals == NULL) return fail(parser, parser->line, "'%.40s' is not 'key = value'", key);
  *equals = '\0';
  return parse_pair(parser, trim(key), trim(equals + 1));
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
  } else if (rig->board.camera_trigger[0] == '\0') {
    snprintf(why, 160, "missing key 'linux.camera_trigger'; 'fixed' where nothing is to be set");
  } else if (rig->camera_frame_bytes != (double)bytes) {
    snprintf(why, 160, "'camera.frame_bytes' must be %zu, which width_px x height_px take", bytes);
  } else if (sensor->edge_triggered && rig_projector_light_us(rig) < shortest_us) {
    snprintf(why, 160, "an edge-triggered exposure is the projector's, %.0f us; LEDs need %.0f us",
             rig_projector_light_us(rig), shortest_us);
  }
  return why[0] == '\0';
}

static enum lam_status require_every_key(struct parser* parser) {
  for (size_t i = 0; i < kNumberCount; i++) {
    if (!parser->number_seen[i]) return fail(parser, 0, "missing key '%s'", kNumbers[i].name);
  }
  for (size_t i = 0; i < kChoiceCount; i++) {
    if (!parser->choice_seen[i]) return fail(parser, 0, "missing key '%s'", kChoices[i].name);
  }
  if (parser->rig->led_count == 0) return fail(parser, 0, "missing key 'led.0'");
  const char* missing = rig_linux_missing(&parser->rig->board);
  if (parser->rig->board.given && missing != NULL) {
    return fail(parser, 0, "missing key '%s'", missing);
  }
  if (parser->rig->projector_light_periods != floor(parser->rig->projector_light_periods)) {
    return fail(parser, 0, "'projector.light_periods' must be a whole number");
  }
  char why[160];
  if (!cameras_fit_together(parser->rig, why)) return fail(parser, 0, "%s", why);
  return pattern_can_be_drawn(parser->rig, why) ? LAM_OK : fail(parser, 0, "%s", why);
}

enum lam_status rig_parse(const char* text, size_t length, struct rig* rig,
                          struct rig_error* error) {
  struct parser parser = {.rig = rig, .error = error};
  memset(rig, 0, sizeof *rig);
  memset(error, 0, sizeof *error);
  if (length > RIG_MAX_TEXT_BYTES) {
    return fail(&parser, 0, "longer than %d bytes", RIG_MAX_TEXT_BYTES);
  }
  for (size_t at = 0; at < length;) {
    const char* newline = memchr(text + at, '\n', length - at);
    const size_t bytes = newline ? (size_t)(newline - (text + at)) : length - at;
    parser.line++;
    char line[kMaxLineBytes];
    if (bytes >= sizeof line) return fail(&parser, parser.line, "line too long");
    if (memchr(text + at, '\0', bytes)) return fail(&parser, parser.line, "not a text file");
    memcpy(line, text + at, bytes);
    line[bytes] = '\0';
    const enum lam_status status = parse_line(&parser, line);
    if (status != LAM_OK) return status;
    at += bytes + 1;
  }
  return require_every_key(&parser);
}

double rig_pwm_period_us(const struct rig* rig) { return kPwmSteps * 1e6 / rig->leds_gsclk_hz; }

double rig_refresh_us(const struct rig* rig) { return 1e6 / rig->projector_refresh_hz; }

double rig_projector_light_us(const struct rig* rig) {
  return rig->projector_light_periods * rig_refresh_us(rig);
}

double rig_shift_us(const struct rig* rig) { return CHAIN_BITS * 1e6 / rig->leds_spi_hz; }
