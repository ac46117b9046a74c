// What one burst's light does to an eye that looks straight into a light source: IEC 62471:2006,
// risk of the retina. LEDs and projector have images of their own on it, an eye looks into one at a
// time, and the worse one binds. White light of LEDs, lasers and lamps behind glass has next to
// nothing below 400 nm and above 780 nm, so the limits for actinic ultraviolet (4.3.1), UV-A
// (4.3.2) and infrared (4.3.6, 4.3.7) do not bind. The projector's label (IEC 62471-5) holds
// besides.
#ifndef LAMELLA_FIRMWARE_DOSE_H
#define LAMELLA_FIRMWARE_DOSE_H

#include "burst.h"
#include "rig.h"

struct dose {
  // Blue light, 4.3.3: weighted radiance times the time that the source is lit, taken at full.
  double blue_j_per_m2_sr;
  double bursts_per_day;  // that one exposure limit holds, as if the eye did not recover
  // Thermal, 4.3.5: the longest pulse's share of its limit; 1 is the limit.
  double thermal_share;
};

struct dose dose_of_leds(const struct rig* rig, const struct burst_plan* plan);

// The source is the lens's exit pupil, white towards the eye from LAMP's rise until the lamp has
// settled dark: between exposures too, whatever the patterns show.
struct dose dose_of_projector(const struct rig* rig, const struct burst_plan* plan);

// The angle that a source subtends at the eye, held between what an eye resolves and the largest
// that makes a difference (3.2, alpha_min and alpha_max).
double dose_angular_subtense_rad(double diameter_mm, double distance_mm);

// Of weighted radiance, for a pulse of 10 us to 10 s: 50000 / (alpha t^0.25) (4.3.5). Longer ones
// are judged as 10 s are.
double dose_thermal_limit_w_per_m2_sr(double alpha_rad, double pulse_us);

#define DOSE_BLUE_LIMIT_J_PER_M2_SR 1e6  // 4.3.3, for exposures of up to 10^4 s

#endif
