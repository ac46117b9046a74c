// Plays a timeline on hardware and records when each edge really happened.
#ifndef LAMELLA_FIRMWARE_PLAYER_H
#define LAMELLA_FIRMWARE_PLAYER_H

#include <stdbool.h>

#include "burst.h"
#include "hal.h"
#include "timeline.h"

// How one edge went.
struct played_edge {
  double actual_us;  // from the timeline's zero
  double kernel_us;  // the same by a loop-back input, where it saw the edge
  bool done, late, kernel_saw_it;
};

struct player {
  struct hal* hal;
  const struct rig* rig;
  const struct burst_plan* plan;
  const struct timeline* timeline;
  uint8_t streams[BURST_MAX_STEPS]
                 [CHAIN_BYTES];  // bits of each LED step, made before anything moves
  double zero_us;                // the timeline's zero on the rig's clock
  size_t next;
  size_t last_edge[BURST_MAX_STEPS];  // of each step, among those that the player makes happen
  struct played_edge played[TIMELINE_MAX_EDGES];
  size_t late_count;
  size_t first_late;  // timeline->count while no edge is late
};

// Encodes every LED step and puts the hardware at the zero of a new burst.
enum lam_status player_start(struct player* player, struct hal* hal, const struct rig* rig,
                             const struct burst_plan* plan, const struct timeline* timeline);

// The same for a timeline that goes on with the burst under way.
enum lam_status player_resume(struct player* player, struct hal* hal, const struct rig* rig,
                              const struct burst_plan* plan, const struct timeline* timeline);

bool player_is_done(const struct player* player);

// Time until the next edge is due; negative where it is overdue.
double player_slack_us(const struct player* player);

// Records what loop-back inputs have seen by now. Only where there is slack: it asks the kernel.
void player_hear_loopbacks(struct player* player);

// Waits for the next edge, plays it, records it. On LAM_HARDWARE the lights are off: a device
// failed, or an edge of BLANK or LAMP was later than leds.longest_on_us - leds.light_us (at least
// player.tolerance_us), so that a light could have shone for longer than it may.
enum lam_status player_step(struct player* player);

// True where every edge of the step has been played, late or not.
bool player_step_is_over(const struct player* player, size_t step);

// True where an edge of the step was late, or the analyser still moved or settled in its exposure.
bool player_step_is_marked(const struct player* player, size_t step);

// When an edge of this step really happened, or NaN where there is none.
double player_actual_us(const struct player* player, size_t step, enum edge_line line,
                        unsigned value);

#endif
