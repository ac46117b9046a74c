#include "dose.h"

#include <math.h>

static const double kLeastAlphaRad = 0.0017, kLargestAlphaRad = 0.1;
static const double kLongestThermalUs = 10e6;

struct source {
  double blue_w_per_m2_sr, thermal_w_per_m2_sr, alpha_rad;
};

struct lit {
  double total_us, longest_us;
};

double dose_angular_subtense_rad(double diameter_mm, double distance_mm) {
  return fmin(fmax(diameter_mm / distance_mm, kLeastAlphaRad), kLargestAlphaRad);
}

double dose_thermal_limit_w_per_m2_sr(double alpha_rad, double pulse_us) {
  return 50000 / (alpha_rad * pow(fmin(pulse_us, kLongestThermalUs) * 1e-6, 0.25));
}

static void add_pulse(struct lit* lit, double pulse_us) {
  lit->total_us += pulse_us;
  lit->longest_us = fmax(lit->longest_us, pulse_us);
}

static struct lit lit_by_leds(const struct burst_plan* plan) {
  struct lit lit = {0};
  for (size_t i = 0; i < plan->count; i++) {
    if (!burst_step_is_lit_by_leds(&plan->steps[i])) continue;
    add_pulse(&lit, plan->times[i].light_off_us - plan->times[i].light_on_us);
  }
  return lit;
}

// The lamp stays on from one projector step to the next of its take.
static struct lit lit_by_lamp(const struct rig* rig, const struct burst_plan* plan) {
  struct lit lit = {0};
  double on_us = 0;
  for (size_t i = 0; i < plan->count; i++) {
    if (burst_step_is_lit_by_leds(&plan->steps[i])) continue;
    if (plan->times[i].lamp_us > 0) on_us = plan->times[i].lamp_us;
    const bool stays_on = i + 1 < plan->count && !burst_step_is_lit_by_leds(&plan->steps[i + 1]) &&
                          plan->times[i + 1].lamp_us <= 0;
    if (stays_on) continue;
    add_pulse(&lit, plan->times[i].close_us + rig->projector_lamp_settle_us - on_us);
  }
  return lit;
}

static struct dose dose_of(const struct source* source, const struct lit* lit) {
  if (lit->total_us <= 0) return (struct dose){.bursts_per_day = INFINITY};
  const double blue = source->blue_w_per_m2_sr * lit->total_us * 1e-6;
  const double limit = dose_thermal_limit_w_per_m2_sr(source->alpha_rad, lit->longest_us);
  return (struct dose){.blue_j_per_m2_sr = blue,
                       .bursts_per_day = floor(DOSE_BLUE_LIMIT_J_PER_M2_SR / blue),
                       .thermal_share = source->thermal_w_per_m2_sr / limit};
}

struct dose dose_of_leds(const struct rig* rig, const struct burst_plan* plan) {
  const struct source led = {
      rig->light_led_blue_w_per_m2_sr, rig->light_led_thermal_w_per_m2_sr,
      dose_angular_subtense_rad(rig->light_led_diameter_mm, rig->light_eye_distance_mm)};
  const struct lit lit = lit_by_leds(plan);
  return dose_of(&led, &lit);
}

struct dose dose_of_projector(const struct rig* rig, const struct burst_plan* plan) {
  const struct source lens = {rig->light_projector_blue_w_per_m2_sr,
                              rig->light_projector_thermal_w_per_m2_sr,
                              dose_angular_subtense_rad(rig->light_projector_pupil_mm,
                                                        rig->light_projector_eye_distance_mm)};
  const struct lit lit = lit_by_lamp(rig, plan);
  return dose_of(&lens, &lit);
}
