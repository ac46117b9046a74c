#include "dose.h"

#include <math.h>

static const double kLeastAlphaRad = 0.0017, kLargestAlphaRad = 0.1;

double dose_angular_subtense_rad(const struct rig* rig) {
  const double alpha_rad = rig->light_led_diameter_mm / rig->light_eye_distance_mm;
  return fmin(fmax(alpha_rad, kLeastAlphaRad), kLargestAlphaRad);
}

double dose_thermal_limit_w_per_m2_sr(double alpha_rad, double pulse_us) {
  return 50000 / (alpha_rad * pow(pulse_us * 1e-6, 0.25));
}

struct dose dose_of_burst(const struct rig* rig, const struct burst_plan* plan) {
  double lit_us = 0, longest_us = 0;
  for (size_t i = 0; i < plan->count; i++) {
    if (!burst_step_is_lit_by_leds(&plan->steps[i])) continue;
    const double pulse_us = plan->times[i].light_off_us - plan->times[i].light_on_us;
    lit_us += pulse_us;
    longest_us = fmax(longest_us, pulse_us);
  }
  if (lit_us <= 0) return (struct dose){.bursts_per_day = INFINITY};
  const double blue = rig->light_led_blue_w_per_m2_sr * lit_us * 1e-6;
  const double limit = dose_thermal_limit_w_per_m2_sr(dose_angular_subtense_rad(rig), longest_us);
  return (struct dose){.blue_j_per_m2_sr = blue,
                       .bursts_per_day = floor(DOSE_BLUE_LIMIT_J_PER_M2_SR / blue),
                       .thermal_share = rig->light_led_thermal_w_per_m2_sr / limit};
}
