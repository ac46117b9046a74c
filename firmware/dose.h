// What one burst's light does to an eye that looks straight into an LED: IEC 62471:2006, risk of
// the retina. White LEDs emit next to nothing below 400 nm and above 780 nm, so the limits for
// actinic ultraviolet (4.3.1), UV-A (4.3.2) and infrared (4.3.6, 4.3.7) do not bind. The projector
// has a label of its own (IEC 62471-5) and is not counted.
#ifndef LAMELLA_FIRMWARE_DOSE_H
#define LAMELLA_FIRMWARE_DOSE_H

#include "burst.h"
#include "rig.h"

struct dose {
  // Blue light, 4.3.3: weighted radiance times the time that LEDs are on, each taken at full level.
  double blue_j_per_m2_sr;
  double bursts_per_day;  // that one exposure limit holds, as if the eye did not recover
  // Thermal, 4.3.5: the longest pulse's share of its limit; 1 is the limit.
  double thermal_share;
};

struct dose dose_of_burst(const struct rig* rig, const struct burst_plan* plan);

// The angle that the source subtends at the eye, held between what an eye resolves and the largest
// that makes a difference (3.2, alpha_min and alpha_max).
double dose_angular_subtense_rad(const struct rig* rig);

// Of weighted radiance, for a pulse of 10 us to 10 s: 50000 / (alpha t^0.25) (4.3.5).
double dose_thermal_limit_w_per_m2_sr(double alpha_rad, double pulse_us);

#define DOSE_BLUE_LIMIT_J_PER_M2_SR 1e6  // 4.3.3, for exposures of up to 10^4 s

#endif
