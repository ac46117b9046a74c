// Plays a timeline on hardware and records when each edge really happened.
#ifndef LAMELLA_FIRMWARE_PLAYER_H
#define LAMELLA_FIRMWARE_PLAYER_H

#include <stdbool.h>

#include "burst.h"
#include "hal.h"
#include "timeline.h"

// How one edge went.
struct played_edge {
  double actual_us;  // from the burst's zero
  bool done, late;
};

struct player {
  struct hal* hal;
  const struct rig* rig;
  const struct burst_plan* plan;
  const struct timeline* timeline;
  uint8_t streams[BURST_MAX_STEPS]
                 [CHAIN_BYTES];  // bits of each LED step, made before anything moves
  double zero_us;                // the burst's zero on the rig's clock
  size_t next;
  struct played_edge played[TIMELINE_MAX_EDGES];
  size_t late_count;
  size_t first_late;  // timeline->count while no edge is late
};

// Encodes every LED step and puts the hardware at the burst's zero.
enum lam_status player_start(struct player* player, struct hal* hal, const struct rig* rig,
                             const struct burst_plan* plan, const struct timeline* timeline);

bool player_is_done(const struct player* player);

// Time until the next edge is due; negative where it is overdue.
double player_slack_us(const struct player* player);

// Waits for the next edge, plays it, records it. On LAM_HARDWARE the lights are off: a device
// failed, or an edge of BLANK or LAMP was later than leds.longest_on_us - leds.light_us (at least
// player.tolerance_us), so that a light could have shone for longer than it may.
enum lam_status player_step(struct player* player);

// True where an edge of the step was late, or the analyser still moved or settled in its exposure.
bool player_step_is_marked(const struct player* player, size_t step);

// When an edge of this step really happened, or NaN where there is none.
double player_actual_us(const struct player* player, size_t step, enum edge_line line,
                        unsigned value);

#endif
