// The check before play: reads the edges alone, knowing nothing of the plan they came from.
#ifndef LAMELLA_FIRMWARE_SAFETY_H
#define LAMELLA_FIRMWARE_SAFETY_H

#include "rig.h"
#include "status.h"
#include "timeline.h"

enum safety_rule {
  SAFETY_ORDER,         // edges are in order of time, every pulse is closed, lights end off
  SAFETY_LED_ON_TIME,   // no pulse longer than leds.longest_on_us
  SAFETY_LED_DUTY,      // within any leds.duty_window_us
  SAFETY_PWM_PERIODS,   // an LED pulse is a whole number of PWM periods
  SAFETY_CHAIN_DARK,    // the chain is shifted and latched, in this order, with BLANK high
  SAFETY_LIGHT_INSIDE,  // LED light lies inside an exposure
  SAFETY_READOUT,       // no exposure opens during a readout, or closes during an overlapped one
  SAFETY_ANALYSER,      // none while the analyser moves or settles, and one move at most
  SAFETY_REFRESH,       // projector light: stable, whole refresh periods
  SAFETY_ONE_LIGHT,     // LEDs and projector never light the same exposure, one of them does
  SAFETY_RULES,
};

struct safety_finding {
  enum safety_rule rule;
  size_t edge;     // which edge broke it; timeline->count where the end of the burst did
  char text[128];  // one line for the operator
};

// What was played before a timeline that goes on with a burst, on its own clock: before its zero.
struct safety_past {
  double rest_us;  // the last frame is read out and the lamp dark from here on
  size_t pulses;   // of LED light
  double on_us[BURST_MAX_STEPS], off_us[BURST_MAX_STEPS];
};

// The same for a timeline that follows others of its burst.
enum lam_status safety_check_after(const struct rig* rig, const struct safety_past* past,
                                   const struct timeline* timeline, struct safety_finding* finding);

// LAM_UNSAFE with the first finding, or LAM_OK.
enum lam_status safety_check(const struct rig* rig, const struct timeline* timeline,
                             struct safety_finding* finding);

#endif
