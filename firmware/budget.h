// What a burst costs that its edges do not show: light on the sensor, heat in the LEDs, room for
// the photographs. Worked out before anything moves.
#ifndef LAMELLA_FIRMWARE_BUDGET_H
#define LAMELLA_FIRMWARE_BUDGET_H

#include "burst.h"
#include "dose.h"
#include "rig.h"
#include "status.h"

// No more than three flashes within any second (WCAG 2.3.1, ITU-R BT.1702) are taken to be harmless
// to everybody.
enum { BUDGET_HARMLESS_FLASHES_PER_S = 3 };

struct budget {
  // White surface at the subject, evenly lit, behind the analyser: share of the sensor's
  // saturation. Luminance E T / pi, exposure 0.65 L t / N^2, saturation 78 / ISO (ISO 12232).
  double leds_share, projector_share;
  double junction_c;                      // hottest, every LED step taken as all LEDs at full
  double frames_bytes;                    // of the whole burst, both cameras
  double memory_bytes;                    // what the disk has not taken when the burst ends
  double flashes_per_s;                   // LED pulses that begin within the worst second
  struct dose leds_dose, projector_dose;  // of an eye that looks into one of them
  char refusal[160];                      // empty where the rig can do it
};

// LAM_UNSAFE with a reason in `refusal`, or LAM_OK.
enum lam_status budget_check(const struct rig* rig, const struct burst_plan* plan,
                             struct budget* budget);

#endif
