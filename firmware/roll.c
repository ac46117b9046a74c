#include "roll.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void roll_begin(struct roll* roll, const struct rig* rig) {
  memset(roll, 0, sizeof *roll);
  roll->rig = rig;
}

// The step of the first take that is of the same thing.
static size_t place_of(const struct roll* roll, const struct burst_step* step) {
  const struct burst_plan* first = &roll->takes[0].plan;
  size_t place = 0;
  for (; place < first->count; place++) {
    const struct burst_step* other = &first->steps[place];
    if (other->role == step->role && other->index == step->index &&
        other->crossed == step->crossed) {
      break;
    }
  }
  return place;
}

struct take* roll_add_take(struct roll* roll, const struct burst_plan* plan,
                           const struct timeline* timeline) {
  struct take* take = &roll->takes[roll->take_count];
  take->plan = *plan;
  take->timeline = *timeline;
  take->first_shot = roll->shot_count;
  for (size_t i = 0; i < plan->count; i++) {
    roll->shots[roll->shot_count++] =
        (struct shot){.take = (uint8_t)roll->take_count,
                      .step = (uint8_t)i,
                      .place = (uint8_t)place_of(roll, &plan->steps[i]),
                      .replaced_by = -1};
  }
  roll->take_count++;
  return take;
}

void roll_withdraw_take(struct roll* roll) {
  roll->take_count--;
  roll->shot_count = roll->takes[roll->take_count].first_shot;
}

struct take* roll_newest_take(struct roll* roll) {
  return &roll->takes[roll->take_count - 1];
}

void roll_replace(struct roll* roll) {
  for (size_t i = roll_newest_take(roll)->first_shot; i < roll->shot_count; i++) {
    for (size_t k = 0; k < i; k++) {
      struct shot* before = &roll->shots[k];
      if (before->place == roll->shots[i].place && before->replaced_by < 0) {
        before->replaced_by = (int)i;
      }
    }
  }
}

void roll_judge(struct roll* roll) {
  for (size_t i = 0; i < roll->shot_count; i++) {
    struct shot* shot = &roll->shots[i];
    shot->bad = shot->dropped || player_step_is_marked(&roll->takes[shot->take].player, shot->step);
  }
}

double roll_zero_us(const struct roll* roll, size_t take) {
  return roll->takes[take].player.zero_us - roll->takes[0].player.zero_us;
}

double roll_open_us(const struct roll* roll, const struct shot* shot) {
  return roll_zero_us(roll, shot->take) + roll->takes[shot->take].plan.times[shot->step].open_us;
}

size_t roll_edge_count(const struct roll* roll) {
  size_t count = 0;
  for (size_t i = 0; i < roll->take_count; i++) count += roll->takes[i].timeline.count;
  return count;
}

size_t roll_late_count(const struct roll* roll) {
  size_t count = 0;
  for (size_t i = 0; i < roll->take_count; i++) count += roll->takes[i].player.late_count;
  return count;
}

void roll_describe_edge(const struct roll* roll, size_t index, lamella_v1_TimedEdge* timed) {
  size_t number = 0;
  while (index >= roll->takes[number].timeline.count) index -= roll->takes[number++].timeline.count;
  const struct take* take = &roll->takes[number];
  const struct edge* edge = &take->timeline.edges[index];
  const struct played_edge* played = &take->player.played[index];
  const double zero_us = roll_zero_us(roll, number);
  const size_t shot = take->first_shot + edge->step;
  *timed = (lamella_v1_TimedEdge){.planned_us = zero_us + edge->t_us,
                                  .actual_us = zero_us + played->actual_us,
                                  .tolerance_us = edge->tolerance_us,
                                  .value = edge->value,
                                  .step = roll->shots[shot].place,
                                  .shot = (uint32_t)shot,
                                  .replaced = roll->shots[shot].replaced_by >= 0,
                                  .has_kernel_us = played->kernel_saw_it,
                                  .kernel_us = zero_us + played->kernel_us};
  snprintf(timed->line, sizeof timed->line, "%s", timeline_line_name(edge->line));
}

static void describe_times(const struct roll* roll, const struct shot* shot,
                           lamella_v1_Frame* frame) {
  const struct take* take = &roll->takes[shot->take];
  const double zero_us = roll_zero_us(roll, shot->take);
  const double delay_us = roll->rig->camera_start_delay_us;
  const bool leds = burst_step_is_lit_by_leds(&take->plan.steps[shot->step]);
  const double on_us = player_actual_us(&take->player, shot->step, EDGE_TRIGGER, 1);
  const double off_us = player_actual_us(&take->player, shot->step, EDGE_TRIGGER, 0);
  frame->trigger_us = zero_us + on_us;
  frame->exposure_us = off_us - on_us;
  frame->has_light_on_us = frame->has_light_off_us = true;
  frame->light_on_us = zero_us + (leds ? player_actual_us(&take->player, shot->step, EDGE_BLANK, 0)
                                       : on_us + delay_us);
  frame->light_off_us = zero_us + (leds ? player_actual_us(&take->player, shot->step, EDGE_BLANK, 1)
                                        : off_us + delay_us);
}

void roll_describe_frame(const struct roll* roll, size_t number, unsigned camera,
                         lamella_v1_Frame* frame) {
  const struct shot* shot = &roll->shots[number];
  const struct burst_step* what = &roll->takes[shot->take].plan.steps[shot->step];
  *frame = (lamella_v1_Frame)lamella_v1_Frame_init_zero;
  frame->has_step = frame->has_role = frame->has_index = frame->has_analyser = true;
  frame->step = shot->place;
  frame->role = what->role;
  frame->index = what->index;
  frame->analyser = what->crossed || camera == 1 ? lamella_v1_Frame_Analyser_CROSS
                                                 : lamella_v1_Frame_Analyser_PARALLEL;
  frame->has_camera = frame->has_shot = true;
  snprintf(frame->camera, sizeof frame->camera, "%s", camera == 0 ? "left" : "right");
  frame->shot = (uint32_t)number;
  describe_times(roll, shot, frame);
}
