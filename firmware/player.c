#include "player.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tick.h"

enum { kStackBytes = 64 * 1024, kPageBytes = 4096, kMostZeros = 8 };
static const double kSeenWithinUs = 2000;  // of the edge played: less than any pulse lasts

static struct hal_pattern pattern_of(const struct burst_step* step) {
  static const lamella_v1_PatternSpan_Kind kKinds[] = {
      [lamella_v1_Frame_Role_FRINGE] = lamella_v1_PatternSpan_Kind_FRINGE,
      [lamella_v1_Frame_Role_BLACK] = lamella_v1_PatternSpan_Kind_BLACK,
      [lamella_v1_Frame_Role_DOTS] = lamella_v1_PatternSpan_Kind_DOTS,
      [lamella_v1_Frame_Role_FRONT] = lamella_v1_PatternSpan_Kind_WHITE,
      [lamella_v1_Frame_Role_STRIPES] = lamella_v1_PatternSpan_Kind_STRIPES,
  };
  return (struct hal_pattern){kKinds[step->role], step->index};
}

static bool is_observed(enum edge_line line) { return line == EDGE_VBLANK || line == EDGE_ARRIVED; }

// Locked memory covers what is there: the stack is made to reach as deep as playing goes.
static void touch_stack(void) {
  volatile uint8_t room[kStackBytes];
  for (size_t i = 0; i < sizeof room; i += kPageBytes) room[i] = 0;
}

// Nothing is left to be encoded, looked up or paged in once edges are played.
static void make_ready(struct player* player, struct hal* hal, const struct rig* rig,
                       const struct burst_plan* plan, const struct timeline* timeline) {
  touch_stack();
  memset(player, 0, sizeof *player);
  player->hal = hal;
  player->rig = rig;
  player->plan = plan;
  player->timeline = timeline;
  player->first_late = timeline->count;
  for (size_t i = 0; i < plan->count; i++) {
    if (!burst_step_is_lit_by_leds(&plan->steps[i])) continue;
    uint16_t codes[RIG_MAX_LEDS];
    burst_led_codes(rig, plan->steps[i].role, codes);
    led_chain_encode(rig, codes, player->streams[i]);
  }
  for (size_t i = 0; i < timeline->count; i++) {
    if (!is_observed(timeline->edges[i].line)) player->last_edge[timeline->edges[i].step] = i;
  }
}

// Each vblank stands elsewhere between the kernel's ticks: the first at which no critical edge
// meets one becomes the zero. Where a display's rate lets every vblank meet one, the last is taken.
static enum lam_status keep_clear_of_ticks(struct player* player) {
  struct hal* hal = player->hal;
  enum lam_status status = LAM_OK;
  for (int tried = 1; status == LAM_OK && tried < kMostZeros; tried++) {
    if (!tick_meets_edge(hal, player->timeline, player->zero_us)) break;
    status = hal->resume(hal->self, &player->zero_us);
  }
  return status;
}

enum lam_status player_start(struct player* player, struct hal* hal, const struct rig* rig,
                             const struct burst_plan* plan, const struct timeline* timeline) {
  make_ready(player, hal, rig, plan, timeline);
  const enum lam_status status = hal->prepare(hal->self, &player->zero_us);
  return status == LAM_OK ? keep_clear_of_ticks(player) : status;
}

enum lam_status player_resume(struct player* player, struct hal* hal, const struct rig* rig,
                              const struct burst_plan* plan, const struct timeline* timeline) {
  make_ready(player, hal, rig, plan, timeline);
  const enum lam_status status = hal->resume(hal->self, &player->zero_us);
  return status == LAM_OK ? keep_clear_of_ticks(player) : status;
}

bool player_is_done(const struct player* player) { return player->next == player->timeline->count; }

double player_slack_us(const struct player* player) {
  if (player_is_done(player)) return INFINITY;
  const double due_us = player->zero_us + player->timeline->edges[player->next].t_us;
  return due_us - player->hal->now_us(player->hal->self);
}

static void record(struct player* player, size_t index, double at_us) {
  const struct edge* edge = &player->timeline->edges[index];
  struct played_edge* played = &player->played[index];
  played->done = true;
  played->actual_us = at_us - player->zero_us;
  played->late = played->actual_us - edge->t_us > edge->tolerance_us;
  if (!played->late) return;
  player->late_count++;
  if (index < player->first_late) player->first_late = index;
}

// The played edge that a loop-back saw: of that line and level, nearest in time. timeline->count
// where none is near: noise on the line, or an edge of nobody's.
static size_t find_seen(const struct player* player, const struct hal_seen_edge* seen) {
  const enum edge_line line = seen->line == HAL_BLANK ? EDGE_BLANK : EDGE_TRIGGER;
  const double at_us = seen->at_us - player->zero_us;
  size_t nearest = player->timeline->count;
  double nearest_us = kSeenWithinUs;
  for (size_t i = 0; i < player->next; i++) {
    const struct edge* edge = &player->timeline->edges[i];
    const double apart_us = fabs(player->played[i].actual_us - at_us);
    if (edge->line != line || edge->value != seen->level || apart_us > nearest_us) continue;
    nearest = i;
    nearest_us = apart_us;
  }
  return nearest;
}

void player_hear_loopbacks(struct player* player) {
  struct hal_seen_edge seen;
  while (player->hal->next_seen(player->hal->self, &seen)) {
    const size_t index = find_seen(player, &seen);
    if (index == player->timeline->count) continue;
    player->played[index].kernel_us = seen.at_us - player->zero_us;
    player->played[index].kernel_saw_it = true;
  }
}

// Edges that the hardware, not the player, makes happen: recorded when they are first seen.
static void observe(struct player* player, size_t end) {
  struct hal* hal = player->hal;
  for (size_t i = 0; i < end; i++) {
    const enum edge_line line = player->timeline->edges[i].line;
    if (!is_observed(line) || player->played[i].done) continue;
    double at_us = 0;
    if ((line == EDGE_VBLANK ? hal->flipped : hal->arrived)(hal->self, &at_us)) {
      record(player, i, at_us);
    }
  }
}

// What never happened within the burst is late, by as much as is known.
static void give_up_observing(struct player* player) {
  for (size_t i = 0; i < player->timeline->count; i++) {
    if (player->played[i].done) continue;
    record(player, i, player->hal->now_us(player->hal->self));
    if (player->played[i].late) continue;
    player->played[i].late = true;
    player->late_count++;
    if (i < player->first_late) player->first_late = i;
  }
}

// How late an edge of light may be: LEDs that are lit until then have shone for as long as they
// may.
static double latest_us(const struct rig* rig) {
  return fmax(rig->leds_longest_on_us - rig->leds_light_us, rig->player_tolerance_us);
}

// A sequencer that was kept from its work for so long has lost hold of the lights.
static enum lam_status check_in_time(struct player* player, const struct edge* edge, double at_us) {
  const double late_us = at_us - player->zero_us - edge->t_us;
  const bool light = edge->line == EDGE_BLANK || edge->line == EDGE_LAMP;
  if (!light || late_us <= latest_us(player->rig)) return LAM_OK;
  snprintf(player->hal->error, sizeof player->hal->error,
           "%s of step %u came %.0f us late, which is past the lights' limit of %.0f us",
           timeline_line_name(edge->line), edge->step, late_us, latest_us(player->rig));
  return LAM_HARDWARE;
}

// Light follows an exposure's beginning, and the chain may have taken longer to load than the
// heart may rest.
static enum lam_status trigger(struct hal* hal, bool level, double* at_us) {
  const enum lam_status status = hal->set_line(hal->self, HAL_TRIGGER, level, at_us);
  return status == LAM_OK && level ? hal_beat(hal) : status;
}

static enum lam_status act(struct player* player, const struct edge* edge, double* at_us) {
  struct hal* hal = player->hal;
  switch (edge->line) {
    case EDGE_SHIFT:
      return hal->shift_leds(hal->self, player->streams[edge->step], NULL, at_us);
    case EDGE_LATCH:
      return hal->set_line(hal->self, HAL_LATCH, edge->value, at_us);
    case EDGE_BLANK:
      return hal->set_line(hal->self, HAL_BLANK, edge->value, at_us);
    case EDGE_TRIGGER:
      return trigger(hal, edge->value, at_us);
    case EDGE_LAMP:
      return hal->set_line(hal->self, HAL_LAMP, edge->value, at_us);
    case EDGE_COMMIT:
      return hal->commit_pattern(hal->self, pattern_of(&player->plan->steps[edge->step]), at_us);
    default:
      return hal->move_analyser(hal->self, edge->value, at_us);
  }
}

static bool is_set_line(enum edge_line line) {
  return line == EDGE_LATCH || line == EDGE_BLANK || line == EDGE_TRIGGER || line == EDGE_LAMP;
}

// Between the end of the wait and the call that acts lies nothing that could be done before it.
enum lam_status player_step(struct player* player) {
  struct hal* hal = player->hal;
  const size_t index = player->next;
  const struct edge* edge = &player->timeline->edges[index];
  const double due_us = player->zero_us + edge->t_us;
  const double lead_us = is_set_line(edge->line) ? hal->lead_us : 0;
  double at_us = hal->wait_until_us(hal->self, due_us - lead_us);
  if (!is_observed(edge->line)) {
    enum lam_status status = check_in_time(player, edge, at_us);
    if (status == LAM_OK) status = act(player, edge, &at_us);
    if (status == LAM_OK) status = check_in_time(player, edge, at_us);
    if (status != LAM_OK) {
      hal->lights_off(hal->self);
      return status;
    }
    record(player, index, at_us);
  }
  player->next++;
  observe(player, player->next);
  if (!player_is_done(player)) return LAM_OK;
  give_up_observing(player);
  player_hear_loopbacks(player);
  return LAM_OK;
}

bool player_step_is_over(const struct player* player, size_t step) {
  return player->next > player->last_edge[step];
}

// A late arrival spoils every exposure that began before the analyser had settled.
static bool edge_marks_step(const struct player* player, size_t index, size_t step) {
  const struct edge* edge = &player->timeline->edges[index];
  if (!player->played[index].late) return false;
  if (edge->line != EDGE_ARRIVED || step < edge->step) return edge->step == step;
  const double still_us = player->played[index].actual_us + player->rig->analyser_settle_us;
  return step == edge->step || player->plan->times[step].open_us < still_us;
}

bool player_step_is_marked(const struct player* player, size_t step) {
  for (size_t i = 0; i < player->timeline->count; i++) {
    if (edge_marks_step(player, i, step)) return true;
  }
  return false;
}

double player_actual_us(const struct player* player, size_t step, enum edge_line line,
                        unsigned value) {
  for (size_t i = 0; i < player->timeline->count; i++) {
    const struct edge* edge = &player->timeline->edges[i];
    if (edge->step == step && edge->line == line && edge->value == value) {
      return player->played[i].actual_us;
    }
  }
  return NAN;
}
