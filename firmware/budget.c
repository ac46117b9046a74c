#include "budget.h"

#include <math.h>
#include <stdio.h>

enum { kCameras = 2 };
static const double kPi = 3.14159265358979323846;
static const double kSaturationLuxS = 78;  // at ISO 1
static const double kLensFactor = 0.65;    // ISO 12232: lens transmission, vignetting, pi/4
static const double kFlashWindowUs = 1e6;

static double white_share(const struct rig* rig, double lux, double light_us) {
  const double luminance = lux * rig->camera_analyser_transmission / kPi;
  const double exposure =
      kLensFactor * luminance * light_us * 1e-6 / (rig->camera_f_number * rig->camera_f_number);
  return exposure * rig->camera_iso / kSaturationLuxS;
}

// One thermal time constant from junction to ambient: warms during pulses, cools between them.
static double hottest_junction_c(const struct rig* rig, const struct burst_plan* plan) {
  const double full_k = rig->leds_power_w * rig->leds_thermal_k_per_w;
  double above_k = 0, since_us = 0, hottest_k = 0;
  for (size_t i = 0; i < plan->count; i++) {
    if (!burst_step_is_lit_by_leds(&plan->steps[i])) continue;
    const struct step_times* t = &plan->times[i];
    above_k *= exp(-(t->light_on_us - since_us) / rig->leds_thermal_time_us);
    const double lit_us = t->light_off_us - t->light_on_us;
    above_k = full_k + (above_k - full_k) * exp(-lit_us / rig->leds_thermal_time_us);
    since_us = t->light_off_us;
    hottest_k = fmax(hottest_k, above_k);
  }
  return rig->leds_ambient_c + hottest_k;
}

static double flashes_per_s(const struct burst_plan* plan) {
  size_t most = 0;
  for (size_t i = 0; i < plan->count; i++) {
    size_t flashes = 0;
    for (size_t k = i; k < plan->count; k++) {
      if (plan->times[k].light_on_us > plan->times[i].light_on_us + kFlashWindowUs) break;
      flashes += burst_step_is_lit_by_leds(&plan->steps[k]);
    }
    if (flashes > most) most = flashes;
  }
  return (double)most;
}

static void refuse_dose(const struct dose* dose, const char* source, char* refusal, size_t size) {
  if (refusal[0] != '\0') return;
  if (dose->blue_j_per_m2_sr > DOSE_BLUE_LIMIT_J_PER_M2_SR) {
    snprintf(refusal, size,
             "blue light: a burst is %.3g J/m2sr in an eye that looks into %s; IEC 62471 allows "
             "%.0g",
             dose->blue_j_per_m2_sr, source, DOSE_BLUE_LIMIT_J_PER_M2_SR);
  } else if (dose->thermal_share > 1) {
    snprintf(refusal, size,
             "thermal: the longest pulse of %s is %.2f times what IEC 62471 allows an eye's retina",
             source, dose->thermal_share);
  }
}

static void find_refusal(const struct rig* rig, struct budget* b) {
  const struct {
    double share;
    const char* name;
  } lights[] = {{b->leds_share, "light.leds_lux"}, {b->projector_share, "light.projector_lux"}};
  for (size_t i = 0; i < 2 && b->refusal[0] == '\0'; i++) {
    if (lights[i].share >= rig->light_least_share) continue;
    snprintf(b->refusal, sizeof b->refusal,
             "%s exposes white to %.2g %% of saturation; light.least_share asks %.2g %%",
             lights[i].name, 100 * lights[i].share, 100 * rig->light_least_share);
  }
  if (b->refusal[0] == '\0' && b->junction_c > rig->leds_highest_junction_c) {
    snprintf(b->refusal, sizeof b->refusal,
             "LEDs would reach %.0f C; leds.highest_junction_c is %.0f C", b->junction_c,
             rig->leds_highest_junction_c);
  }
  if (b->refusal[0] == '\0' && b->memory_bytes > rig->store_capacity_bytes) {
    snprintf(b->refusal, sizeof b->refusal,
             "%.0f MB of photographs less what the disk takes meanwhile leave %.0f MB for a "
             "memory of %.0f MB (store.capacity_bytes)",
             b->frames_bytes * 1e-6, b->memory_bytes * 1e-6, rig->store_capacity_bytes * 1e-6);
  }
}

enum lam_status budget_check(const struct rig* rig, const struct burst_plan* plan,
                             struct budget* budget) {
  *budget = (struct budget){
      .leds_share = white_share(rig, rig->light_leds_lux, rig->leds_light_us),
      .projector_share = white_share(rig, rig->light_projector_lux, rig_projector_light_us(rig)),
      .junction_c = hottest_junction_c(rig, plan),
      .frames_bytes = (double)(kCameras * plan->count) * rig->camera_frame_bytes,
      .flashes_per_s = flashes_per_s(plan),
      .leds_dose = dose_of_leds(rig, plan),
      .projector_dose = dose_of_projector(rig, plan),
  };
  const double taken_bytes = rig->store_disk_bytes_per_s * plan->duration_us * 1e-6;
  budget->memory_bytes = fmax(0, budget->frames_bytes - taken_bytes);
  find_refusal(rig, budget);
  refuse_dose(&budget->leds_dose, "an LED", budget->refusal, sizeof budget->refusal);
  refuse_dose(&budget->projector_dose, "the projector's lens", budget->refusal,
              sizeof budget->refusal);
  if (budget->refusal[0] == '\0' && plan->duration_us > rig->burst_longest_us) {
    snprintf(budget->refusal, sizeof budget->refusal,
             "the burst takes %.2f s; burst.longest_us asks a subject to sit still for %.2f s",
             plan->duration_us * 1e-6, rig->burst_longest_us * 1e-6);
  }
  return budget->refusal[0] == '\0' ? LAM_OK : LAM_UNSAFE;
}
