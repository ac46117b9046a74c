#include "burst.h"

#include <math.h>
#include <string.h>

#include "burst_clock.h"
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

static void search_from(struct search* s, size_t place, struct burst_clock clock, double pairs_us);

static void try_step(struct search* s, size_t place, size_t i, struct burst_clock clock,
                     double pairs_us) {
  burst_clock_step(s->rig, &s->steps[i], &clock, &s->times[i]);
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

static void search_from(struct search* s, size_t place, struct burst_clock clock, double pairs_us) {
  for (size_t i = 0; i < s->count; i++) {
    if (may_come_next(s, i, clock.crossed)) try_step(s, place, i, clock, pairs_us);
  }
}

void burst_order(const struct rig* rig, const struct burst_step steps[], size_t count,
                 bool starts_crossed, struct burst_plan* plan) {
  struct search s = {.rig = rig, .steps = steps, .count = count, .starts_crossed = starts_crossed};
  s.best_cost_us = INFINITY;
  for (size_t i = 0; i < count; i++) s.partner[i] = burst_partner(steps, count, i);
  search_from(&s, 0, (struct burst_clock){.crossed = starts_crossed}, 0);
  memset(plan, 0, sizeof *plan);
  plan->count = count;
  plan->starts_crossed = starts_crossed;
  for (size_t i = 0; i < count; i++) plan->steps[i] = steps[s.best[i]];
  burst_time(rig, plan);
}
