#include "burst_bound.h"

#include <math.h>

#include "burst_clock.h"

// Steps under one analyser, by light.
struct side {
  size_t leds, projector;
};

// The least clock after so many steps of one side, the last by LEDs (0) or by the projector (1).
struct table {
  struct burst_clock least[BURST_MAX_STEPS + 1][BURST_MAX_STEPS + 1][2];
};

static const struct burst_clock kNever = {.close_us = INFINITY};

static struct burst_step any_step(bool leds, bool crossed) {
  return (struct burst_step){
      leds ? lamella_v1_Frame_Role_GRADIENT_FULL : lamella_v1_Frame_Role_BLACK, 0, crossed};
}

static struct side count_side(const struct burst_step steps[], size_t count, bool crossed) {
  struct side side = {0};
  for (size_t i = 0; i < count; i++) {
    if (steps[i].crossed != crossed) continue;
    *(burst_step_is_lit_by_leds(&steps[i]) ? &side.leds : &side.projector) += 1;
  }
  return side;
}

static void extend(const struct rig* rig, const struct burst_clock* from, struct burst_step step,
                   struct burst_clock* least) {
  struct burst_clock clock = *from;
  struct step_times times;
  burst_clock_step(rig, &step, &clock, &times);
  if (clock.close_us < least->close_us) *least = clock;
}

// Plays one side from where either clock of `least` stands; `least` becomes those after it.
static void play_side(const struct rig* rig, struct side side, bool crossed,
                      struct burst_clock least[2]) {
  struct table table;
  for (size_t l = 0; l <= side.leds; l++) {
    for (size_t p = 0; p <= side.projector; p++)
      table.least[l][p][0] = table.least[l][p][1] = kNever;
  }
  table.least[0][0][0] = least[0];
  table.least[0][0][1] = least[1];
  for (size_t l = 0; l <= side.leds; l++) {
    for (size_t p = 0; p <= side.projector; p++) {
      for (size_t last = 0; last < 2; last++) {
        const struct burst_clock* clock = &table.least[l][p][last];
        if (isinf(clock->close_us)) continue;
        if (l < side.leds) extend(rig, clock, any_step(true, crossed), &table.least[l + 1][p][0]);
        if (p < side.projector) {
          extend(rig, clock, any_step(false, crossed), &table.least[l][p + 1][1]);
        }
      }
    }
  }
  least[0] = table.least[side.leds][side.projector][0];
  least[1] = table.least[side.leds][side.projector][1];
}

static double least_duration_us(const struct rig* rig, const struct burst_step steps[],
                                size_t count, bool starts_crossed) {
  struct burst_clock least[2] = {{.crossed = starts_crossed}, kNever};
  play_side(rig, count_side(steps, count, starts_crossed), starts_crossed, least);
  play_side(rig, count_side(steps, count, !starts_crossed), !starts_crossed, least);
  return fmin(least[0].close_us, least[1].close_us) + rig->camera_readout_us;
}

// Of one step after any other: how long it waits, and how long it exposes. The least over the
// lights that are among the steps, over either light before it and over the projector's phase,
// which is gone through finely; 1e-3 of a refresh is taken off for what lies between.
struct leasts {
  double wait_us, exposure_us;
};

static struct leasts least_of(const struct rig* rig, const struct burst_step steps[], size_t count,
                              bool moves) {
  enum { kPhases = 1000 };
  struct leasts least = {INFINITY, INFINITY};
  for (size_t i = 0; i < count; i++) {
    for (size_t k = 0; k < 2 * kPhases; k++) {
      const double close_us = 1e6 + (double)(k / 2) / kPhases * rig_refresh_us(rig);
      struct burst_clock clock = {close_us, true, k % 2, steps[i].crossed != moves};
      struct step_times times;
      burst_clock_step(rig, &steps[i], &clock, &times);
      least.wait_us = fmin(least.wait_us, times.open_us - close_us);
      least.exposure_us = fmin(least.exposure_us, times.close_us - times.open_us);
    }
  }
  least.wait_us = fmax(0, least.wait_us - rig_refresh_us(rig) / kPhases);
  return least;
}

static size_t count_pairs(const struct burst_step steps[], size_t count) {
  size_t pairs = 0;
  for (size_t i = 0; i < count; i++) pairs += burst_partner(steps, count, i) < i;
  return pairs;
}

static double least_separation_us(const struct rig* rig, const struct burst_step steps[],
                                  size_t count) {
  const double pairs = (double)count_pairs(steps, count);
  if (pairs == 0) return 0;
  const struct leasts across = least_of(rig, steps, count, true);
  const struct leasts within = least_of(rig, steps, count, false);
  const double cycle_us = within.wait_us + within.exposure_us;
  return pairs * (across.exposure_us + across.wait_us) + pairs * (pairs - 1) * cycle_us;
}

struct burst_bound burst_bound(const struct rig* rig, const struct burst_step steps[], size_t count,
                               bool starts_crossed) {
  struct burst_bound bound = {.duration_us = least_duration_us(rig, steps, count, starts_crossed)};
  bound.cost_us =
      bound.duration_us + rig->burst_pair_weight * least_separation_us(rig, steps, count);
  return bound;
}
