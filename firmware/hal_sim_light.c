#include "hal_sim_light.h"

#include <math.h>
#include <string.h>

static const double kPwmSteps = 4096;

void sim_light_init(struct sim_light* light, const struct rig* rig,
                    const struct sim_faults* faults) {
  memset(light, 0, sizeof *light);
  light->rig = rig;
  light->faults = faults;
  sim_chain_power_up(&light->chain, rig->leds_have_functions);
  light->chain.missing_chip = faults->missing_chip + 1;
  light->chain.broken_chip = faults->broken_chip + 1;
  light->chain.forgetful_chip = faults->forgetful_chip + 1;
  light->blank = true;
  light->analyser_rad = rig->analyser_parks_crossed ? M_PI_2 : 0;
}

void sim_light_restart(struct sim_light* light) {
  light->analyser_rad = sim_light_analyser_rad(light, INFINITY);
  light->blank = true;
  light->pulse_count = light->flip_count = light->lamp_count = light->move_count = 0;
}

static void end_pulse(struct sim_light* light, double t_us) {
  if (light->pulse_count > 0) light->pulses[light->pulse_count - 1].off_us = t_us;
}

// What an LED gives for its code: a dead one nothing, and of two that are swapped each the other's.
static uint16_t led_code(const struct sim_light* light, int led) {
  const struct sim_faults* faults = light->faults;
  if (led == faults->dead_led) return 0;
  int wired = led;
  if (led == faults->swapped_leds[0]) wired = faults->swapped_leds[1];
  if (led == faults->swapped_leds[1]) wired = faults->swapped_leds[0];
  if ((size_t)wired >= light->rig->led_count) return 0;
  const struct led_place* place = &light->rig->leds[wired];
  const uint16_t code = sim_chain_code(&light->chain, place->chip, place->output);
  return led == faults->weak_led ? code / 2 : code;
}

static bool begin_pulse(struct sim_light* light, double t_us, double counter_zero_us) {
  if (light->pulse_count == SIM_MAX_EVENTS) return false;
  struct sim_pulse* pulse = &light->pulses[light->pulse_count++];
  pulse->on_us = t_us;
  pulse->off_us = INFINITY;
  pulse->counter_zero_us = counter_zero_us;
  for (size_t i = 0; i < light->rig->led_count; i++) pulse->codes[i] = led_code(light, (int)i);
  return true;
}

bool sim_light_blank(struct sim_light* light, bool level, double t_us) {
  if (level == light->blank) return true;
  light->blank = level;
  if (!level) return begin_pulse(light, t_us, t_us);
  end_pulse(light, t_us);
  return true;
}

bool sim_light_latch(struct sim_light* light, bool level, double t_us) {
  const bool rises = level && !light->chain.latch;
  sim_chain_latch(&light->chain, level);
  if (light->blank || !rises) return true;
  const double counter_zero_us = light->pulses[light->pulse_count - 1].counter_zero_us;
  end_pulse(light, t_us);
  return begin_pulse(light, t_us, counter_zero_us);
}

bool sim_light_flip(struct sim_light* light, struct hal_pattern pattern, double vblank_us) {
  if (light->flip_count == SIM_MAX_EVENTS) return false;
  light->flips[light->flip_count++] = (struct sim_flip){vblank_us, pattern};
  return true;
}

bool sim_light_lamp(struct sim_light* light, bool on, double t_us) {
  if (light->lamp_count == SIM_MAX_EVENTS) return false;
  light->lamps[light->lamp_count++] = (struct sim_lamp){t_us, on};
  return true;
}

bool sim_light_move(struct sim_light* light, double to_rad, double from_us, double to_us) {
  if (light->move_count == SIM_MAX_EVENTS) return false;
  const double from_rad = sim_light_analyser_rad(light, from_us);
  light->moves[light->move_count++] = (struct sim_move){from_us, to_us, from_rad, to_rad};
  return true;
}

double sim_light_analyser_rad(const struct sim_light* light, double t_us) {
  double angle_rad = light->analyser_rad;
  for (size_t i = 0; i < light->move_count && light->moves[i].from_us <= t_us; i++) {
    const struct sim_move* move = &light->moves[i];
    const double share = fmin(1, (t_us - move->from_us) / (move->to_us - move->from_us));
    angle_rad = move->from_rad + share * (move->to_rad - move->from_rad);
  }
  return angle_rad;
}

// On-time of an output since its counter started: `code` of every 4096 greyscale clocks.
static double on_time_us(double code, double t_us, double period_us) {
  const double periods = floor(t_us / period_us);
  const double on_us = code / kPwmSteps * period_us;
  return periods * on_us + fmin(t_us - periods * period_us, on_us);
}

static void put_codes(const struct sim_light* light, const struct sim_pulse* pulse,
                      lamella_v1_LedSpan* span) {
  const double period_us = rig_pwm_period_us(light->rig);
  const double from_us = span->on_us - pulse->counter_zero_us;
  const double to_us = span->off_us - pulse->counter_zero_us;
  for (size_t i = 0; i < light->rig->led_count; i++) {
    const double on_us = on_time_us(pulse->codes[i], to_us, period_us) -
                         on_time_us(pulse->codes[i], from_us, period_us);
    const long mean = lround(on_us / (to_us - from_us) * kPwmSteps);
    const uint16_t code = (uint16_t)(mean < CHAIN_FULL_CODE ? mean : CHAIN_FULL_CODE);
    span->codes.bytes[2 * i] = (uint8_t)code;
    span->codes.bytes[2 * i + 1] = (uint8_t)(code >> 8);
  }
  span->codes.size = (pb_size_t)(2 * light->rig->led_count);
}

static bool report_leds(const struct sim_light* light, lamella_v1_ExposureReport* report) {
  const size_t room = sizeof report->leds / sizeof report->leds[0];
  for (size_t i = 0; i < light->pulse_count; i++) {
    const struct sim_pulse* pulse = &light->pulses[i];
    const double on_us = fmax(pulse->on_us, report->open_us);
    const double off_us = fmin(pulse->off_us, report->close_us);
    if (off_us <= on_us) continue;
    if (report->leds_count == room) return false;
    lamella_v1_LedSpan* span = &report->leds[report->leds_count++];
    span->on_us = on_us;
    span->off_us = off_us;
    put_codes(light, pulse, span);
  }
  return true;
}

// A switched lamp does what it did before until it is steady: the worst that the rig file allows.
static bool lamp_shines(const struct sim_light* light, double t_us) {
  bool on = false;
  for (size_t i = 0; i < light->lamp_count; i++) {
    if (light->lamps[i].at_us + light->rig->projector_lamp_settle_us <= t_us) {
      on = light->lamps[i].on;
    }
  }
  return on;
}

// The panel is black while it settles to a new pattern, and before the first.
static struct hal_pattern pattern_shown(const struct sim_light* light, double t_us) {
  struct hal_pattern pattern = {lamella_v1_PatternSpan_Kind_BLACK, 0};
  for (size_t i = 0; i < light->flip_count; i++) {
    const double changes_us = light->flips[i].vblank_us + light->rig->projector_latency_us;
    if (t_us < changes_us) break;
    pattern = light->flips[i].pattern;
    if (t_us < changes_us + light->rig->projector_settle_us) {
      pattern = (struct hal_pattern){lamella_v1_PatternSpan_Kind_BLACK, 0};
    }
  }
  return pattern;
}

static struct hal_pattern projector_light(const struct sim_light* light, double t_us) {
  if (!lamp_shines(light, t_us)) {
    return (struct hal_pattern){lamella_v1_PatternSpan_Kind_DARK, 0};
  }
  return pattern_shown(light, t_us);
}

// The next moment after t_us at which the projector's light may change, at most limit_us.
static double next_change_us(const struct sim_light* light, double t_us, double limit_us) {
  const struct rig* rig = light->rig;
  double next_us = limit_us;
  for (size_t i = 0; i < light->lamp_count; i++) {
    const double at_us = light->lamps[i].at_us + rig->projector_lamp_settle_us;
    if (at_us > t_us) next_us = fmin(next_us, at_us);
  }
  for (size_t i = 0; i < light->flip_count; i++) {
    const double at_us = light->flips[i].vblank_us + rig->projector_latency_us;
    if (at_us > t_us) next_us = fmin(next_us, at_us);
    if (at_us + rig->projector_settle_us > t_us) {
      next_us = fmin(next_us, at_us + rig->projector_settle_us);
    }
  }
  return next_us;
}

static bool report_patterns(const struct sim_light* light, lamella_v1_ExposureReport* report) {
  const size_t room = sizeof report->patterns / sizeof report->patterns[0];
  for (double t_us = report->open_us; t_us < report->close_us;) {
    const double end_us = next_change_us(light, t_us, report->close_us);
    const struct hal_pattern pattern = projector_light(light, t_us);
    lamella_v1_PatternSpan* last =
        report->patterns_count > 0 ? &report->patterns[report->patterns_count - 1] : NULL;
    if (last != NULL && last->kind == pattern.kind && last->index == pattern.index) {
      last->off_us = end_us;
    } else if (report->patterns_count == room) {
      return false;
    } else {
      report->patterns[report->patterns_count++] =
          (lamella_v1_PatternSpan){t_us, end_us, pattern.kind, pattern.index};
    }
    t_us = end_us;
  }
  return true;
}

static double next_bend_us(const struct sim_light* light, double t_us, double limit_us) {
  double next_us = limit_us;
  for (size_t i = 0; i < light->move_count; i++) {
    if (light->moves[i].from_us > t_us) next_us = fmin(next_us, light->moves[i].from_us);
    if (light->moves[i].to_us > t_us) next_us = fmin(next_us, light->moves[i].to_us);
  }
  return next_us;
}

static bool report_analyser(const struct sim_light* light, lamella_v1_ExposureReport* report) {
  const size_t room = sizeof report->analyser / sizeof report->analyser[0];
  for (double t_us = report->open_us; t_us < report->close_us;) {
    if (report->analyser_count == room) return false;
    const double end_us = next_bend_us(light, t_us, report->close_us);
    report->analyser[report->analyser_count++] = (lamella_v1_AnalyserSpan){
        t_us, end_us, sim_light_analyser_rad(light, t_us), sim_light_analyser_rad(light, end_us)};
    t_us = end_us;
  }
  return true;
}

bool sim_light_report(const struct sim_light* light, unsigned camera, double open_us,
                      double close_us, lamella_v1_ExposureReport* report) {
  memset(report, 0, sizeof *report);
  report->camera = camera;
  report->open_us = open_us;
  report->close_us = close_us;
  report->led_reference_us = light->rig->leds_light_us;
  report->projector_reference_us = rig_projector_light_us(light->rig);
  if (!report_leds(light, report) || !report_patterns(light, report)) return false;
  return camera != 0 || report_analyser(light, report);
}
