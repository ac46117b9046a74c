// A burst: twenty photographs, put into the cheapest order and timed. Nothing moves here.
#ifndef LAMELLA_FIRMWARE_BURST_H
#define LAMELLA_FIRMWARE_BURST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/session.pb.h"
#include "rig.h"

// More steps than the paper's: a burst's retakes count too where it is judged as a whole.
enum { BURST_MAX_STEPS = 32, BURST_STEPS = 20 };

// What one photograph is of.
struct burst_step {
  lamella_v1_Frame_Role role;
  uint8_t index;
  bool crossed;  // the left camera's analyser
};

// What an exposure waited for since the last one closed: the last of its conditions to hold.
enum burst_wait {
  BURST_WAIT_START,      // nothing: the burst begins
  BURST_WAIT_SHUTTER,    // the shutter's least pause
  BURST_WAIT_READOUT,    // of the last frame
  BURST_WAIT_ANALYSER,   // to move and settle
  BURST_WAIT_CHAIN,      // LED codes shifted, latched
  BURST_WAIT_LAMP,       // of the projector, to go on or off
  BURST_WAIT_PROJECTOR,  // vblank, latency and settling of a pattern
  BURST_WAITS,
};

// When one step happens, from the burst's zero. Times not used by its kind of light are 0.
struct step_times {
  double analyser_us;           // the actuator starts; 0: it does not move before this step
  double lamp_us;               // the lamp is switched; 0: it is as it should be
  double shift_us, latch_us;    // LED steps
  double commit_us, vblank_us;  // projector steps
  double trigger_us, untrigger_us;
  double light_on_us, light_off_us;
  double open_us, close_us;  // the sensor integrates
  double wait_us;            // from the last exposure's close to this one's opening
  enum burst_wait wait;      // for what
};

struct burst_plan {
  size_t count;
  struct burst_step steps[BURST_MAX_STEPS];
  struct step_times times[BURST_MAX_STEPS];
  bool starts_crossed;
  double cost_us;      // duration + weight * sum of pair separations
  double duration_us;  // to the end of the last readout
};

// The steps of the paper's burst, in the order of its table.
extern const struct burst_step kBurstSteps[BURST_STEPS];

const char* burst_wait_name(enum burst_wait wait);

bool burst_step_is_lit_by_leds(const struct burst_step* step);

// The other photograph of the same light under the other analyser, or `count` where there is none.
size_t burst_partner(const struct burst_step steps[], size_t count, size_t index);

// Times steps in the order given; one actuator move where `crossed` changes.
void burst_time(const struct rig* rig, struct burst_plan* plan);

// Finds the order of least cost among all with one actuator move and parallel/cross pairs mirrored
// about it: every pair is then centred on the move, so that one subject moving steadily gives
// one S and one D. The analyser starts where it stands, `starts_crossed`.
void burst_order(const struct rig* rig, const struct burst_step steps[], size_t count,
                 bool starts_crossed, struct burst_plan* plan);

// Greyscale codes of an LED step: (1 + w.a) / 2 of full for a gradient along a.
void burst_led_codes(const struct rig* rig, lamella_v1_Frame_Role role, uint16_t codes[]);

#endif
