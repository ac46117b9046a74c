#include "burst.h"

#include <math.h>
#include <string.h>

#include "led_chain.h"

#define ROLE(name) lamella_v1_Frame_Role_##name

const struct burst_step kBurstSteps[BURST_STEPS] = {
    {ROLE(GRADIENT_FULL), 0, false}, {ROLE(GRADIENT_FULL), 0, true}, {ROLE(GRADIENT_X), 0, false},
    {ROLE(GRADIENT_X), 0, true},     {ROLE(GRADIENT_Y), 0, false},   {ROLE(GRADIENT_Y), 0, true},
    {ROLE(GRADIENT_Z), 0, false},    {ROLE(GRADIENT_Z), 0, true},    {ROLE(FRINGE), 0, true},
    {ROLE(FRINGE), 1, true},         {ROLE(FRINGE), 2, true},        {ROLE(FRINGE), 3, true},
    {ROLE(BLACK), 0, true},          {ROLE(DOTS), 0, true},          {ROLE(FRONT), 0, false},
    {ROLE(FRONT), 0, true},          {ROLE(STRIPES), 0, true},       {ROLE(STRIPES), 1, true},
    {ROLE(STRIPES), 2, true},        {ROLE(STRIPES), 3, true},
};

// After an exposure the slow lines move one after the other; the chain is shifted after them.
static const double kAfterCloseUs = 100;

bool burst_step_is_lit_by_leds(const struct burst_step* step) {
  return step->role >= ROLE(GRADIENT_FULL) && step->role <= ROLE(GRADIENT_Z);
}

size_t burst_partner(const struct burst_step steps[], size_t count, size_t index) {
  for (size_t i = 0; i < count; i++) {
    if (steps[i].role == steps[index].role && steps[i].index == steps[index].index &&
        steps[i].crossed != steps[index].crossed) {
      return i;
    }
  }
  return count;
}

const char* burst_wait_name(enum burst_wait wait) {
  static const char* const kNames[BURST_WAITS] = {
      [BURST_WAIT_START] = "start",         [BURST_WAIT_SHUTTER] = "shutter",
      [BURST_WAIT_READOUT] = "readout",     [BURST_WAIT_ANALYSER] = "analyser",
      [BURST_WAIT_CHAIN] = "LED chain",     [BURST_WAIT_LAMP] = "lamp",
      [BURST_WAIT_PROJECTOR] = "projector",
  };
  return wait < BURST_WAITS ? kNames[wait] : "?";
}

// What the next step's times depend on.
struct clockwork {
  double close_us;  // of the last exposure
  bool any_step, lamp_on, crossed;
};

// The exposure opens at t_us at the earliest.
static void wait_for(struct step_times* times, enum burst_wait wait, double t_us) {
  if (t_us <= times->open_us) return;
  times->open_us = t_us;
  times->wait = wait;
}

// A camera that an edge triggers integrates for one length alone: the longer one.
static double exposure_us(const struct rig* rig, bool leds) {
  return leds && !rig->sensor.edge_triggered ? rig->leds_light_us + 2 * rig->camera_guard_us
                                             : rig_projector_light_us(rig);
}

// The last trigger may fall late within its tolerance; its readout is then over as much later. An
// overlapped one must be over when the next exposure closes.
static void wait_for_camera(const struct rig* rig, const struct clockwork* clock, bool leds,
                            struct step_times* times) {
  if (!clock->any_step) return;
  // No trigger before the last exposure has closed: a camera that is asked too soon does not hear.
  const double pause_us = clock->close_us + rig->camera_start_delay_us +
                          rig->player_critical_tolerance_us + kAfterCloseUs / 4;
  const double read_out_us =
      clock->close_us + rig->camera_readout_us + rig->player_critical_tolerance_us;
  const double overlap_us = rig->camera_readout_overlaps ? exposure_us(rig, leds) : 0;
  wait_for(times, BURST_WAIT_SHUTTER, pause_us);
  wait_for(times, BURST_WAIT_READOUT, read_out_us - overlap_us);
}

static void wait_for_analyser(const struct rig* rig, const struct clockwork* clock, bool crossed,
                              struct step_times* times) {
  if (crossed == clock->crossed) return;
  times->analyser_us = clock->close_us + kAfterCloseUs / 4;
  wait_for(times, BURST_WAIT_ANALYSER,
           times->analyser_us + rig->analyser_move_us + rig->analyser_settle_us);
}

static void wait_for_lamp(const struct rig* rig, const struct clockwork* clock, bool on,
                          struct step_times* times) {
  if (clock->lamp_on == on) return;
  times->lamp_us = clock->close_us + kAfterCloseUs / 2;
  wait_for(times, BURST_WAIT_LAMP, times->lamp_us + rig->projector_lamp_settle_us);
}

static void time_led_step(const struct rig* rig, const struct clockwork* clock,
                          struct step_times* times) {
  times->shift_us = clock->close_us + kAfterCloseUs;
  times->latch_us = times->shift_us + rig_shift_us(rig) + kAfterCloseUs;
  const double loaded_us = times->latch_us + rig->leds_latch_us + kAfterCloseUs;
  wait_for(times, BURST_WAIT_CHAIN, loaded_us + rig->camera_start_delay_us);
  times->light_on_us = times->open_us + rig->camera_guard_us;
  times->light_off_us = times->light_on_us + rig->leds_light_us;
}

// The flip is pipelined: its light may change as soon as the last exposure has closed.
static void time_projector_step(const struct rig* rig, const struct clockwork* clock,
                                struct step_times* times) {
  const double refresh_us = rig_refresh_us(rig);
  const double soonest_us = fmax(clock->close_us - rig->projector_latency_us,
                                 rig->projector_commit_lead_us + kAfterCloseUs);
  times->vblank_us = ceil(soonest_us / refresh_us - 1e-9) * refresh_us;
  times->commit_us = times->vblank_us - rig->projector_commit_lead_us;
  wait_for(times, BURST_WAIT_PROJECTOR,
           times->vblank_us + rig->projector_latency_us + rig->projector_settle_us +
               rig->camera_guard_us);
  times->light_on_us = times->open_us;
  times->light_off_us = times->open_us + rig_projector_light_us(rig);
}

static void time_step(const struct rig* rig, const struct burst_step* step, struct clockwork* clock,
                      struct step_times* times) {
  memset(times, 0, sizeof *times);
  const bool leds = burst_step_is_lit_by_leds(step);
  times->open_us = clock->close_us;
  wait_for_camera(rig, clock, leds, times);
  wait_for_analyser(rig, clock, step->crossed, times);
  wait_for_lamp(rig, clock, !leds, times);
  (leds ? time_led_step : time_projector_step)(rig, clock, times);
  times->close_us = times->open_us + exposure_us(rig, leds);
  times->wait_us = times->open_us - clock->close_us;
  times->trigger_us = times->open_us - rig->camera_start_delay_us;
  times->untrigger_us = times->close_us - rig->camera_start_delay_us;
  *clock = (struct clockwork){times->close_us, true, !leds, step->crossed};
}

void burst_time(const struct rig* rig, struct burst_plan* plan) {
  struct clockwork clock = {.crossed = plan->starts_crossed};
  double separation_us = 0;
  for (size_t i = 0; i < plan->count; i++) {
    time_step(rig, &plan->steps[i], &clock, &plan->times[i]);
    const size_t partner = burst_partner(plan->steps, plan->count, i);
    if (partner < i) separation_us += plan->times[i].open_us - plan->times[partner].open_us;
  }
  plan->duration_us = clock.close_us + rig->camera_readout_us;
  plan->cost_us = plan->duration_us + rig->burst_pair_weight * separation_us;
}

void burst_led_codes(const struct rig* rig, lamella_v1_Frame_Role role, uint16_t codes[]) {
  for (size_t i = 0; i < rig->led_count; i++) {
    double level = 1;
    if (role != ROLE(GRADIENT_FULL)) {
      level = (1 + rig->leds[i].direction[role - ROLE(GRADIENT_X)]) / 2;
    }
    codes[i] = (uint16_t)lround(fmin(fmax(level, 0), 1) * CHAIN_FULL_CODE);
  }
}

// Depth-first over orders, keeping the best. Two steps of the same light class, same analyser and
// both (or neither) half of a pair take the same time, so only the first unused of such a group
// is tried; that and the bound leave some ten thousand of the 20! orders, and the result exact.
struct search {
  const struct rig* rig;
  const struct burst_step* steps;
  size_t count;
  bool starts_crossed;
  size_t partner[BURST_MAX_STEPS];
  bool used[BURST_MAX_STEPS];
  size_t order[BURST_MAX_STEPS];
  struct step_times times[BURST_MAX_STEPS];      // by step, not by place
  size_t mirror[BURST_MAX_STEPS], mirror_count;  // pairs begun and not yet completed, a stack
  size_t best[BURST_MAX_STEPS];
  double best_cost_us;
};

static bool same_group(const struct search* s, size_t a, size_t b) {
  return s->steps[a].crossed == s->steps[b].crossed &&
         burst_step_is_lit_by_leds(&s->steps[a]) == burst_step_is_lit_by_leds(&s->steps[b]) &&
         (s->partner[a] == s->count) == (s->partner[b] == s->count);
}

static bool side_is_done(const struct search* s, bool crossed) {
  for (size_t i = 0; i < s->count; i++) {
    if (!s->used[i] && s->steps[i].crossed == crossed) return false;
  }
  return true;
}

static bool may_come_next(const struct search* s, size_t i, bool crossed) {
  if (s->used[i]) return false;
  if (s->steps[i].crossed != crossed && !side_is_done(s, crossed)) return false;
  const bool paired = s->partner[i] < s->count;
  if (paired && s->steps[i].crossed != s->starts_crossed) {
    return s->mirror_count > 0 && s->partner[i] == s->mirror[s->mirror_count - 1];
  }
  for (size_t j = 0; j < i; j++) {
    if (!s->used[j] && same_group(s, i, j)) return false;
  }
  return true;
}

static void search_from(struct search* s, size_t place, struct clockwork clock, double pairs_us);

static void try_step(struct search* s, size_t place, size_t i, struct clockwork clock,
                     double pairs_us) {
  time_step(s->rig, &s->steps[i], &clock, &s->times[i]);
  const bool paired = s->partner[i] < s->count;
  const bool completes = paired && s->used[s->partner[i]];
  if (completes) pairs_us += s->times[i].open_us - s->times[s->partner[i]].open_us;
  const double cost_us =
      clock.close_us + s->rig->camera_readout_us + s->rig->burst_pair_weight * pairs_us;
  if (cost_us >= s->best_cost_us) return;
  const size_t mirror_count = s->mirror_count;
  if (completes) s->mirror_count--;
  if (paired && !completes) s->mirror[s->mirror_count++] = i;
  s->used[i] = true;
  s->order[place] = i;
  if (place + 1 == s->count) {
    s->best_cost_us = cost_us;
    memcpy(s->best, s->order, sizeof s->best);
  } else {
    search_from(s, place + 1, clock, pairs_us);
  }
  s->used[i] = false;
  s->mirror_count = mirror_count;
  if (completes) s->mirror[mirror_count - 1] = s->partner[i];
}

static void search_from(struct search* s, size_t place, struct clockwork clock, double pairs_us) {
  for (size_t i = 0; i < s->count; i++) {
    if (may_come_next(s, i, clock.crossed)) try_step(s, place, i, clock, pairs_us);
  }
}

void burst_order(const struct rig* rig, const struct burst_step steps[], size_t count,
                 bool starts_crossed, struct burst_plan* plan) {
  struct search s = {.rig = rig, .steps = steps, .count = count, .starts_crossed = starts_crossed};
  s.best_cost_us = INFINITY;
  for (size_t i = 0; i < count; i++) s.partner[i] = burst_partner(steps, count, i);
  search_from(&s, 0, (struct clockwork){.crossed = starts_crossed}, 0);
  memset(plan, 0, sizeof *plan);
  plan->count = count;
  plan->starts_crossed = starts_crossed;
  for (size_t i = 0; i < count; i++) plan->steps[i] = steps[s.best[i]];
  burst_time(rig, plan);
}
