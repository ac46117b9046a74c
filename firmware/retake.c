#include "retake.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "budget.h"
#include "safety.h"

// What a retake is judged by.
struct circumstances {
  const struct roll* roll;
  bool stands_crossed;
  double rest_us;    // of the burst's clock: the last take is over, and what it used
  double starts_us;  // of the burst's clock, at the latest
  double widest_us;  // separation among the burst's own pairs
};

// Steps that are wanted.
struct wish {
  size_t count;
  struct burst_step steps[BURST_MAX_STEPS];
};

static bool same_step(const struct burst_step* a, const struct burst_step* b) {
  return a->role == b->role && a->index == b->index && a->crossed == b->crossed;
}

static bool is_wanted(const struct wish* wish, const struct burst_step* step) {
  for (size_t i = 0; i < wish->count; i++) {
    if (same_step(&wish->steps[i], step)) return true;
  }
  return false;
}

static const struct burst_step* step_of(const struct roll* roll, const struct shot* shot) {
  return &roll->takes[shot->take].plan.steps[shot->step];
}

// Nothing of the last take goes on: its frames are read out, its lamp is dark.
static double last_take_rests_us(const struct roll* roll) {
  const struct take* last = &roll->takes[roll->take_count - 1];
  const double close_us = last->plan.times[last->plan.count - 1].close_us;
  return roll_zero_us(roll, roll->take_count - 1) + close_us +
         fmax(roll->rig->camera_readout_us, roll->rig->projector_lamp_settle_us);
}

static double widest_pair_us(const struct burst_plan* plan) {
  double widest_us = 0;
  for (size_t i = 0; i < plan->count; i++) {
    const size_t partner = burst_partner(plan->steps, plan->count, i);
    if (partner < i) {
      widest_us = fmax(widest_us, plan->times[i].open_us - plan->times[partner].open_us);
    }
  }
  return widest_us;
}

// The shot that holds the partner of a step as things stand; NULL where the step has none.
static const struct shot* partner_shot(const struct roll* roll, const struct burst_step* step) {
  for (size_t i = 0; i < roll->shot_count; i++) {
    const struct shot* shot = &roll->shots[i];
    const struct burst_step* other = step_of(roll, shot);
    if (shot->replaced_by < 0 && other->role == step->role && other->index == step->index &&
        other->crossed != step->crossed) {
      return shot;
    }
  }
  return NULL;
}

// True where a step was added whose partner would come too far from it.
static bool add_partner(const struct circumstances* c, const struct burst_plan* plan,
                        struct wish* wish) {
  for (size_t i = 0; i < plan->count && wish->count < BURST_MAX_STEPS; i++) {
    const struct shot* partner = partner_shot(c->roll, &plan->steps[i]);
    if (partner == NULL || is_wanted(wish, step_of(c->roll, partner))) continue;
    const double open_us = c->starts_us + plan->times[i].open_us;
    if (open_us - roll_open_us(c->roll, partner) <= c->widest_us) continue;
    wish->steps[wish->count++] = *step_of(c->roll, partner);
    return true;
  }
  return false;
}

// LED light as it was played, on the clock of a timeline that starts at starts_us.
static void remember_light(const struct circumstances* c, struct safety_past* past) {
  const struct roll* roll = c->roll;
  *past = (struct safety_past){.rest_us = c->rest_us - c->starts_us};
  for (size_t i = 0; i < roll->shot_count; i++) {
    const struct shot* shot = &roll->shots[i];
    if (!burst_step_is_lit_by_leds(step_of(roll, shot))) continue;
    const struct player* player = &roll->takes[shot->take].player;
    const double zero_us = roll_zero_us(roll, shot->take) - c->starts_us;
    past->on_us[past->pulses] = zero_us + player_actual_us(player, shot->step, EDGE_BLANK, 0);
    past->off_us[past->pulses++] = zero_us + player_actual_us(player, shot->step, EDGE_BLANK, 1);
  }
}

static void append_steps(const struct burst_plan* part, double zero_us, struct burst_plan* whole) {
  for (size_t i = 0; i < part->count; i++) {
    struct step_times times = part->times[i];
    if (times.lamp_us > 0) times.lamp_us += zero_us;
    times.light_on_us += zero_us;
    times.light_off_us += zero_us;
    times.open_us += zero_us;
    times.close_us += zero_us;
    times.trigger_us += zero_us;
    times.untrigger_us += zero_us;
    whole->steps[whole->count] = part->steps[i];
    whole->times[whole->count++] = times;
  }
  whole->duration_us = zero_us + part->duration_us;
}

// The burst with all its takes and the new one, as the budget sees it: heat, light and room add up.
static void join_takes(const struct circumstances* c, const struct burst_plan* plan,
                       struct burst_plan* whole) {
  memset(whole, 0, sizeof *whole);
  whole->starts_crossed = c->roll->takes[0].plan.starts_crossed;
  for (size_t i = 0; i < c->roll->take_count; i++) {
    append_steps(&c->roll->takes[i].plan, roll_zero_us(c->roll, i), whole);
  }
  append_steps(plan, c->starts_us, whole);
}

static bool is_allowed(const struct circumstances* c, struct retake* retake) {
  struct safety_past past;
  struct safety_finding finding;
  struct burst_plan whole;
  struct budget budget;
  remember_light(c, &past);
  if (safety_check_after(c->roll->rig, &past, &retake->timeline, &finding) != LAM_OK) {
    snprintf(retake->why_not, sizeof retake->why_not, "%.100s", finding.text);
    return false;
  }
  join_takes(c, &retake->plan, &whole);
  if (budget_check(c->roll->rig, &whole, &budget) != LAM_OK) {
    snprintf(retake->why_not, sizeof retake->why_not, "%.120s", budget.refusal);
    return false;
  }
  return true;
}

// Plans the wish, partners that must come along included.
static bool attempt(const struct circumstances* c, struct wish* wish, struct retake* retake) {
  do {
    if (c->roll->shot_count + wish->count > ROLL_MAX_SHOTS) {
      snprintf(retake->why_not, sizeof retake->why_not, "a burst has at most %d shots",
               ROLL_MAX_SHOTS);
      return false;
    }
    burst_order(c->roll->rig, wish->steps, wish->count, c->stands_crossed, &retake->plan);
  } while (add_partner(c, &retake->plan, wish));
  timeline_build(c->roll->rig, &retake->plan, &retake->timeline);
  return is_allowed(c, retake);
}

static bool may_be_wanted(const struct shot* shot) {
  return shot->take == 0 && shot->bad && shot->replaced_by < 0;
}

static struct circumstances circumstances_of(const struct roll* roll, bool stands_crossed,
                                             double now_us) {
  struct circumstances c = {.roll = roll, .stands_crossed = stands_crossed};
  c.rest_us = last_take_rests_us(roll);
  const double begins_us = fmax(now_us - roll->takes[0].player.zero_us, c.rest_us);
  c.starts_us = begins_us + rig_refresh_us(roll->rig);
  c.widest_us = widest_pair_us(&roll->takes[0].plan);
  return c;
}

bool retake_find(const struct roll* roll, bool stands_crossed, double now_us,
                 struct retake* retake) {
  const struct circumstances c = circumstances_of(roll, stands_crossed, now_us);
  struct wish granted = {0};
  memset(retake, 0, sizeof *retake);
  retake->rest_us = c.rest_us + roll->takes[0].player.zero_us;
  for (size_t i = 0; i < roll->shot_count; i++) {
    const struct shot* shot = &roll->shots[i];
    if (!may_be_wanted(shot) || is_wanted(&granted, step_of(roll, shot))) continue;
    if (roll->take_count == ROLL_MAX_TAKES) {
      snprintf(retake->why_not, sizeof retake->why_not, "a burst has at most %d takes",
               ROLL_MAX_TAKES);
      return false;
    }
    struct wish wish = granted;
    wish.steps[wish.count++] = *step_of(roll, shot);
    if (attempt(&c, &wish, retake)) granted = wish;
  }
  return granted.count > 0 && attempt(&c, &granted, retake);
}
