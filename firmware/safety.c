#include "safety.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

// Rounding of a double over an hour of microseconds, far below any hardware's.
static const double kSlackUs = 1e-3;
static const double kLongAgoUs = -1e12;

// What the lines have come to when the check has read up to an edge.
struct walk {
  const struct rig* rig;
  struct safety_finding* finding;
  size_t edge;
  bool triggered, blank, lamp, shifted;
  double open_us, close_us;  // of the newest exposure; close_us counts once its trigger has fallen
  bool exposure_unjudged;    // it has not closed yet
  double light_on_us;
  bool leds_lit_exposure, lamp_lit_exposure;
  double shift_done_us;
  double lamp_change_us;
  double vblank_us[BURST_MAX_STEPS];  // of every flip: several may be on their way to the light
  size_t flips;
  double analyser_still_us;  // the analyser stands still and settled from here
  int moves;
  double pulse_on_us[BURST_MAX_STEPS * 2], pulse_off_us[BURST_MAX_STEPS * 2];
  size_t pulses;
};

static enum lam_status broken(struct walk* w, enum safety_rule rule, const char* text) {
  w->finding->rule = rule;
  w->finding->edge = w->edge;
  snprintf(w->finding->text, sizeof w->finding->text, "edge %zu: %s", w->edge, text);
  return LAM_UNSAFE;
}

static bool is_whole(double ratio, double slack) { return fabs(ratio - round(ratio)) <= slack; }

static enum lam_status check_duty(struct walk* w) {
  const double window_us = w->rig->leds_duty_window_us;
  const double since_us = w->pulse_off_us[w->pulses - 1] - window_us;
  double on_us = 0;
  for (size_t i = 0; i < w->pulses; i++) {
    on_us += fmax(0, w->pulse_off_us[i] - fmax(w->pulse_on_us[i], since_us));
  }
  if (on_us > w->rig->leds_highest_duty * window_us + kSlackUs) {
    return broken(w, SAFETY_LED_DUTY, "LEDs are on for more than leds.highest_duty allows");
  }
  return LAM_OK;
}

// True while a sensor may integrate: from the trigger on, and for the start delay after it falls.
static bool is_exposing(const struct walk* w, double t_us) {
  return w->triggered || t_us < w->close_us - kSlackUs;
}

static enum lam_status light_comes_on(struct walk* w, double t_us) {
  if (!is_exposing(w, t_us) || t_us < w->open_us - kSlackUs) {
    return broken(w, SAFETY_LIGHT_INSIDE, "LED light comes before the exposure opens");
  }
  if (w->lamp || t_us < w->lamp_change_us + w->rig->projector_lamp_settle_us - kSlackUs) {
    return broken(w, SAFETY_ONE_LIGHT, "LED light comes while the projector shines");
  }
  w->light_on_us = t_us;
  w->leds_lit_exposure = true;
  return LAM_OK;
}

static enum lam_status light_goes_off(struct walk* w, double t_us) {
  // The trigger may have fallen already: the sensor integrates on for its start delay.
  if (!w->triggered && t_us > w->close_us + kSlackUs) {
    return broken(w, SAFETY_LIGHT_INSIDE, "LED light outlasts the exposure");
  }
  const double on_us = t_us - w->light_on_us;
  if (on_us > w->rig->leds_longest_on_us + kSlackUs) {
    return broken(w, SAFETY_LED_ON_TIME, "LEDs are on for longer than leds.longest_on_us");
  }
  if (!is_whole(on_us / rig_pwm_period_us(w->rig), 1e-4)) {
    return broken(w, SAFETY_PWM_PERIODS, "LED light is not a whole number of PWM periods");
  }
  if (w->pulses == sizeof w->pulse_on_us / sizeof w->pulse_on_us[0]) {
    return broken(w, SAFETY_LED_DUTY, "more LED pulses than a burst can have");
  }
  w->pulse_on_us[w->pulses] = w->light_on_us;
  w->pulse_off_us[w->pulses++] = t_us;
  return check_duty(w);
}

static enum lam_status on_blank(struct walk* w, const struct edge* edge) {
  if (w->blank == (edge->value != 0)) return broken(w, SAFETY_ORDER, "BLANK does not change");
  w->blank = edge->value != 0;
  return w->blank ? light_goes_off(w, edge->t_us) : light_comes_on(w, edge->t_us);
}

static enum lam_status on_chain(struct walk* w, const struct edge* edge) {
  if (!w->blank) return broken(w, SAFETY_CHAIN_DARK, "the driver chain moves while LEDs are lit");
  if (edge->line == EDGE_SHIFT) {
    w->shifted = true;
    w->shift_done_us = edge->t_us + rig_shift_us(w->rig);
  } else if (edge->value != 0 && (!w->shifted || edge->t_us < w->shift_done_us - kSlackUs)) {
    return broken(w, SAFETY_CHAIN_DARK, "LATCH comes before the codes are shifted in");
  }
  return LAM_OK;
}

static enum lam_status exposure_opens(struct walk* w, double t_us) {
  const double open_us = t_us + w->rig->camera_start_delay_us;
  const double readout_us = w->rig->camera_readout_overlaps ? 0 : w->rig->camera_readout_us;
  if (open_us < w->close_us + readout_us - kSlackUs) {
    return broken(w, SAFETY_READOUT, "an exposure opens while the last one is read out");
  }
  if (w->exposure_unjudged) {
    return broken(w, SAFETY_READOUT, "a trigger comes before the last exposure has closed");
  }
  if (open_us < w->analyser_still_us - kSlackUs) {
    return broken(w, SAFETY_ANALYSER, "an exposure opens while the analyser moves or settles");
  }
  w->open_us = open_us;
  w->exposure_unjudged = true;
  w->leds_lit_exposure = false;
  return LAM_OK;
}

static double stable_us(const struct walk* w, double vblank_us) {
  return vblank_us + w->rig->projector_latency_us + w->rig->projector_settle_us;
}

static bool is_shown(const struct walk* w, double vblank_us) {
  return stable_us(w, vblank_us) <= w->open_us + kSlackUs;
}

// A flip changes the light from latency to latency + settle after its vblank: all of that lies
// before the exposure or after it.
static bool flip_disturbs(const struct walk* w, double vblank_us) {
  return stable_us(w, vblank_us) > w->open_us + kSlackUs &&
         vblank_us + w->rig->projector_latency_us < w->close_us - kSlackUs;
}

static enum lam_status check_projector_exposure(struct walk* w) {
  const struct rig* rig = w->rig;
  if (!is_whole((w->close_us - w->open_us) / rig_refresh_us(rig), 1e-5)) {
    return broken(w, SAFETY_REFRESH, "a projector exposure is not whole refresh periods");
  }
  bool any_shown = false, any_disturbs = false;
  for (size_t i = 0; i < w->flips; i++) {
    any_shown = any_shown || is_shown(w, w->vblank_us[i]);
    any_disturbs = any_disturbs || flip_disturbs(w, w->vblank_us[i]);
  }
  if (!any_shown || any_disturbs) {
    return broken(w, SAFETY_REFRESH, "the pattern is not stable during an exposure");
  }
  if (w->open_us < w->lamp_change_us + rig->projector_lamp_settle_us - kSlackUs) {
    return broken(w, SAFETY_REFRESH, "an exposure opens before the lamp is steady");
  }
  return LAM_OK;
}

// Once nothing can light it any more: its trigger falls a start delay before it closes.
static enum lam_status judge_exposure(struct walk* w) {
  w->exposure_unjudged = false;
  if (w->leds_lit_exposure && w->lamp_lit_exposure) {
    return broken(w, SAFETY_ONE_LIGHT, "the projector shines into an LED exposure");
  }
  if (w->leds_lit_exposure) return LAM_OK;
  if (!w->lamp_lit_exposure) return broken(w, SAFETY_ONE_LIGHT, "nothing lights an exposure");
  return check_projector_exposure(w);
}

static enum lam_status exposure_closes(struct walk* w, double t_us) {
  const double read_out_us = w->close_us + w->rig->camera_readout_us;
  w->close_us = t_us + w->rig->camera_start_delay_us;
  if (w->close_us < read_out_us - kSlackUs) {
    return broken(w, SAFETY_READOUT, "an exposure closes while the last one is read out");
  }
  w->lamp_lit_exposure = w->lamp;  // it is not switched while a sensor integrates
  return LAM_OK;
}

static enum lam_status on_trigger(struct walk* w, const struct edge* edge) {
  if (w->triggered == (edge->value != 0)) {
    return broken(w, SAFETY_ORDER, "TRIGGER does not change");
  }
  w->triggered = edge->value != 0;
  return w->triggered ? exposure_opens(w, edge->t_us) : exposure_closes(w, edge->t_us);
}

static enum lam_status on_vblank(struct walk* w, const struct edge* edge) {
  if (w->flips == BURST_MAX_STEPS) {
    return broken(w, SAFETY_REFRESH, "more flips than a burst can have");
  }
  w->vblank_us[w->flips++] = edge->t_us;
  return LAM_OK;
}

static enum lam_status on_lamp(struct walk* w, const struct edge* edge) {
  if (is_exposing(w, edge->t_us)) {
    return broken(w, SAFETY_ONE_LIGHT, "the lamp is switched during an exposure");
  }
  if (w->lamp != (edge->value != 0)) w->lamp_change_us = edge->t_us;
  w->lamp = edge->value != 0;
  return LAM_OK;
}

static enum lam_status on_analyser(struct walk* w, const struct edge* edge) {
  if (is_exposing(w, edge->t_us)) {
    return broken(w, SAFETY_ANALYSER, "the analyser starts during an exposure");
  }
  if (++w->moves > 1) return broken(w, SAFETY_ANALYSER, "the analyser moves more than once");
  w->analyser_still_us = edge->t_us + w->rig->analyser_move_us + w->rig->analyser_settle_us;
  return LAM_OK;
}

static enum lam_status on_edge(struct walk* w, const struct edge* edge) {
  switch (edge->line) {
    case EDGE_SHIFT:
    case EDGE_LATCH:
      return on_chain(w, edge);
    case EDGE_BLANK:
      return on_blank(w, edge);
    case EDGE_TRIGGER:
      return on_trigger(w, edge);
    case EDGE_LAMP:
      return on_lamp(w, edge);
    case EDGE_VBLANK:
      return on_vblank(w, edge);
    case EDGE_ANALYSER:
      return on_analyser(w, edge);
    default:
      return LAM_OK;
  }
}

static void recall(struct walk* w, const struct safety_past* past) {
  // rest_us leaves room for the readout and the lamp: they began this much before it.
  w->close_us = past->rest_us - w->rig->camera_readout_us;
  w->lamp_change_us = past->rest_us - w->rig->projector_lamp_settle_us;
  w->pulses = past->pulses;
  memcpy(w->pulse_on_us, past->on_us, past->pulses * sizeof past->on_us[0]);
  memcpy(w->pulse_off_us, past->off_us, past->pulses * sizeof past->off_us[0]);
}

static enum lam_status walk_edges(struct walk* w, const struct timeline* timeline) {
  double t_us = 0;
  for (; w->edge < timeline->count; w->edge++) {
    const struct edge* edge = &timeline->edges[w->edge];
    if (!(edge->t_us >= t_us)) return broken(w, SAFETY_ORDER, "edges are not in order of time");
    t_us = edge->t_us;
    enum lam_status status = LAM_OK;
    if (w->exposure_unjudged && !is_exposing(w, t_us)) status = judge_exposure(w);
    if (status == LAM_OK) status = on_edge(w, edge);
    if (status != LAM_OK) return status;
  }
  if (w->exposure_unjudged && !w->triggered) {
    const enum lam_status status = judge_exposure(w);
    if (status != LAM_OK) return status;
  }
  if (!w->blank || w->lamp || w->triggered) {
    return broken(w, SAFETY_ORDER, "the burst ends with a light on or a shutter open");
  }
  return LAM_OK;
}

enum lam_status safety_check_after(const struct rig* rig, const struct safety_past* past,
                                   const struct timeline* timeline,
                                   struct safety_finding* finding) {
  struct walk w = {.rig = rig, .finding = finding, .blank = true};
  w.analyser_still_us = kLongAgoUs;
  recall(&w, past);
  return walk_edges(&w, timeline);
}

enum lam_status safety_check(const struct rig* rig, const struct timeline* timeline,
                             struct safety_finding* finding) {
  const struct safety_past nothing = {.rest_us = kLongAgoUs};
  return safety_check_after(rig, &nothing, timeline, finding);
}
