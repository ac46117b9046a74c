#include "burst_clock.h"

#include <math.h>
#include <string.h>

// After an exposure the slow lines move one after the other; the chain is shifted after them.
static const double kAfterCloseUs = 100;

const char* burst_wait_name(enum burst_wait wait) {
  static const char* const kNames[BURST_WAITS] = {
      [BURST_WAIT_START] = "start",         [BURST_WAIT_SHUTTER] = "shutter",
      [BURST_WAIT_READOUT] = "readout",     [BURST_WAIT_ANALYSER] = "analyser",
      [BURST_WAIT_CHAIN] = "LED chain",     [BURST_WAIT_LAMP] = "lamp",
      [BURST_WAIT_PROJECTOR] = "projector",
  };
  return wait < BURST_WAITS ? kNames[wait] : "?";
}

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
static void wait_for_camera(const struct rig* rig, const struct burst_clock* clock, bool leds,
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

static void wait_for_analyser(const struct rig* rig, const struct burst_clock* clock, bool crossed,
                              struct step_times* times) {
  if (crossed == clock->crossed) return;
  times->analyser_us = clock->close_us + kAfterCloseUs / 4;
  wait_for(times, BURST_WAIT_ANALYSER,
           times->analyser_us + rig->analyser_move_us + rig->analyser_settle_us);
}

static void wait_for_lamp(const struct rig* rig, const struct burst_clock* clock, bool on,
                          struct step_times* times) {
  if (clock->lamp_on == on) return;
  times->lamp_us = clock->close_us + kAfterCloseUs / 2;
  wait_for(times, BURST_WAIT_LAMP, times->lamp_us + rig->projector_lamp_settle_us);
}

static void time_led_step(const struct rig* rig, const struct burst_clock* clock,
                          struct step_times* times) {
  times->shift_us = clock->close_us + kAfterCloseUs;
  times->latch_us = times->shift_us + rig_shift_us(rig) + kAfterCloseUs;
  const double loaded_us = times->latch_us + rig->leds_latch_us + kAfterCloseUs;
  wait_for(times, BURST_WAIT_CHAIN, loaded_us + rig->camera_start_delay_us);
  times->light_on_us = times->open_us + rig->camera_guard_us;
  times->light_off_us = times->light_on_us + rig->leds_light_us;
}

// The flip is pipelined: its light may change as soon as the last exposure has closed.
static void time_projector_step(const struct rig* rig, const struct burst_clock* clock,
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

void burst_clock_step(const struct rig* rig, const struct burst_step* step,
                      struct burst_clock* clock, struct step_times* times) {
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
  *clock = (struct burst_clock){times->close_us, true, !leds, step->crossed};
}

void burst_time(const struct rig* rig, struct burst_plan* plan) {
  struct burst_clock clock = {.crossed = plan->starts_crossed};
  double separation_us = 0;
  for (size_t i = 0; i < plan->count; i++) {
    burst_clock_step(rig, &plan->steps[i], &clock, &plan->times[i]);
    const size_t partner = burst_partner(plan->steps, plan->count, i);
    if (partner < i) separation_us += plan->times[i].open_us - plan->times[partner].open_us;
  }
  plan->duration_us = clock.close_us + rig->camera_readout_us;
  plan->cost_us = plan->duration_us + rig->burst_pair_weight * separation_us;
}
