#include "timeline.h"

#include <stdbool.h>

const char* timeline_line_name(enum edge_line line) {
  static const char* const kNames[EDGE_LINES] = {
      [EDGE_SHIFT] = "SHIFT",     [EDGE_LATCH] = "LATCH",       [EDGE_BLANK] = "BLANK",
      [EDGE_TRIGGER] = "TRIGGER", [EDGE_LAMP] = "LAMP",         [EDGE_COMMIT] = "COMMIT",
      [EDGE_VBLANK] = "VBLANK",   [EDGE_ANALYSER] = "ANALYSER", [EDGE_ARRIVED] = "ARRIVED",
  };
  return line < EDGE_LINES ? kNames[line] : "?";
}

// Where an edge is being put: one rig's tolerances, one timeline, one step.
struct writer {
  const struct rig* rig;
  struct timeline* timeline;
  size_t step;
};

// Inserts in order of time; among equal times the one written first stays first.
static void put(const struct writer* writer, double t_us, enum edge_line line, uint8_t value) {
  struct timeline* timeline = writer->timeline;
  const bool critical = line == EDGE_BLANK || line == EDGE_TRIGGER;
  const double tolerance_us =
      critical ? writer->rig->player_critical_tolerance_us : writer->rig->player_tolerance_us;
  size_t at = timeline->count++;
  for (; at > 0 && timeline->edges[at - 1].t_us > t_us; at--) {
    timeline->edges[at] = timeline->edges[at - 1];
  }
  timeline->edges[at] = (struct edge){t_us, tolerance_us, line, value, (uint8_t)writer->step};
}

static void put_led_light(const struct writer* writer, const struct step_times* times) {
  put(writer, times->shift_us, EDGE_SHIFT, 0);
  put(writer, times->latch_us, EDGE_LATCH, 1);
  put(writer, times->latch_us + writer->rig->leds_latch_us, EDGE_LATCH, 0);
  put(writer, times->light_on_us, EDGE_BLANK, 0);
  put(writer, times->light_off_us, EDGE_BLANK, 1);
}

static void put_projector_light(const struct writer* writer, const struct step_times* times) {
  put(writer, times->commit_us, EDGE_COMMIT, 0);
  put(writer, times->vblank_us, EDGE_VBLANK, 1);
}

static void put_step(const struct writer* writer, const struct burst_step* step,
                     const struct step_times* times) {
  const bool leds = burst_step_is_lit_by_leds(step);
  if (times->analyser_us > 0) {
    put(writer, times->analyser_us, EDGE_ANALYSER, step->crossed);
    put(writer, times->analyser_us + writer->rig->analyser_move_us, EDGE_ARRIVED, step->crossed);
  }
  if (times->lamp_us > 0) put(writer, times->lamp_us, EDGE_LAMP, !leds);
  (leds ? put_led_light : put_projector_light)(writer, times);
  put(writer, times->trigger_us, EDGE_TRIGGER, 1);
  put(writer, times->untrigger_us, EDGE_TRIGGER, 0);
}

void timeline_build(const struct rig* rig, const struct burst_plan* plan,
                    struct timeline* timeline) {
  struct writer writer = {.rig = rig, .timeline = timeline};
  timeline->count = 0;
  for (writer.step = 0; writer.step < plan->count; writer.step++) {
    put_step(&writer, &plan->steps[writer.step], &plan->times[writer.step]);
  }
  if (plan->count == 0) return;
  writer.step = plan->count - 1;
  put(&writer, plan->times[writer.step].close_us, EDGE_LAMP, 0);
}
