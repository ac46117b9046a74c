#include "hal_sim.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "hal_sim_twin.h"

// How early the real clock wakes up to spin the rest: more than a Linux timer's usual slack.
static const double kSpinUs = 150;
static const double kGraceUs = 0.5;  // for rounding
static const double kEndStopRad = 1e-3;
static const double kHoldUs = 8000;  // of the monostable

static enum lam_status fail(struct hal_sim* sim, const char* text) {
  snprintf(sim->hal.error, sizeof sim->hal.error, "%s", text);
  return LAM_HARDWARE;
}

static double real_now_us(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec * 1e6 + (double)now.tv_nsec * 1e-3;
}

static double now_us(void* self) {
  const struct hal_sim* sim = self;
  return sim->clock == SIM_CLOCK_REAL ? real_now_us() : sim->virtual_now_us;
}

static double wait_until_us(void* self, double t_us) {
  struct hal_sim* sim = self;
  if (sim->clock == SIM_CLOCK_VIRTUAL) {
    return sim->virtual_now_us = fmax(sim->virtual_now_us, t_us);
  }
  const double wake_us = t_us - kSpinUs;
  if (wake_us > real_now_us()) {
    const struct timespec wake = {.tv_sec = (time_t)(wake_us / 1e6),
                                  .tv_nsec = (long)(fmod(wake_us, 1e6) * 1e3)};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, NULL);
  }
  while (real_now_us() < t_us) continue;
  return real_now_us();
}

static double next_vblank_us(const struct hal_sim* sim, double t_us) {
  const double refresh_us = rig_refresh_us(sim->rig);
  const double periods = ceil((t_us - sim->last_vblank_us) / refresh_us - 1e-9);
  return sim->last_vblank_us + fmax(periods, 1) * refresh_us;
}

// Whether the shot before number `shot` has left the sensor at t_us.
static bool is_read_out(const struct hal_sim* sim, double t_us, size_t shot) {
  if (shot == 0) return true;
  return t_us + kGraceUs >= sim->shots[shot - 1].close_us + sim->rig->camera_readout_us;
}

static bool trigger(struct hal_sim* sim, bool level, double t_us) {
  if (level == sim->triggered) return true;
  sim->triggered = level;
  const double effect_us = t_us + sim->rig->camera_start_delay_us;
  struct sim_shot* last = sim->shot_count > 0 ? &sim->shots[sim->shot_count - 1] : NULL;
  if (!level) {
    last->close_us = effect_us;
    last->missed = last->missed || !is_read_out(sim, effect_us, sim->shot_count - 1);
    return true;
  }
  if (sim->shot_count == SIM_MAX_EVENTS) return false;
  // An overlapped readout need only be over when the exposure closes.
  const bool missed = last != NULL && (sim->rig->camera_readout_overlaps
                                           ? effect_us + kGraceUs < last->close_us
                                           : !is_read_out(sim, effect_us, sim->shot_count));
  sim->shots[sim->shot_count] = (struct sim_shot){effect_us, INFINITY, missed};
  __atomic_store_n(&sim->shot_count, sim->shot_count + 1, __ATOMIC_RELEASE);
  return true;
}

static void lights_off(void* self) {
  struct hal_sim* sim = self;
  sim->playing = false;
  pthread_mutex_lock(&sim->light_lock);
  sim_light_blank(&sim->light, true, now_us(sim));
  sim_light_lamp(&sim->light, false, now_us(sim));
  pthread_mutex_unlock(&sim->light_lock);
  trigger(sim, false, now_us(sim));
}

static enum lam_status resume(void* self, double* zero_us) {
  struct hal_sim* sim = self;
  lights_off(sim);
  const size_t moves = sim->light.move_count;
  if (moves > 0) {
    wait_until_us(sim, sim->light.moves[moves - 1].to_us + sim->rig->analyser_settle_us);
  }
  sim->triggered = sim->flip_pending = sim->move_pending = false;
  sim->playing = true;
  *zero_us = next_vblank_us(sim, now_us(sim));
  wait_until_us(sim, *zero_us);
  sim->last_vblank_us = *zero_us;
  return LAM_OK;
}

static enum lam_status prepare(void* self, double* zero_us) {
  struct hal_sim* sim = self;
  const enum lam_status status = resume(sim, zero_us);
  sim_light_restart(&sim->light);
  sim->shot_count = 0;
  sim->pulse_count = sim->shift_count = 0;
  sim->zero_us = *zero_us;
  sim->seen_count = sim->seen_given = 0;
  return status;
}

static enum lam_status arm(void* self) {
  double zero_us = 0;
  return prepare(self, &zero_us);
}

static void delay_light(struct hal_sim* sim) {
  const int pulse = sim->pulse_count++;
  const bool late = sim->faults.late_pulse < 0 || sim->faults.late_pulse == pulse;
  if (late) wait_until_us(sim, now_us(sim) + sim->faults.late_blank_us);
}

static bool loop_back(struct hal_sim* sim, enum hal_line line, bool level, double at_us) {
  if (line != HAL_BLANK && line != HAL_TRIGGER) return true;
  if (sim->seen_count == sizeof sim->seen / sizeof sim->seen[0]) return false;
  sim->seen[sim->seen_count++] = (struct hal_seen_edge){line, level, at_us};
  return true;
}

static void signal_operator(struct hal_sim* sim, enum hal_line line, bool level, double t_us) {
  if (sim->signal_count == SIM_MAX_SIGNALS) return;
  sim->signals[sim->signal_count++] = (struct sim_signal){line, level, t_us};
}

static enum lam_status set_line(void* self, enum hal_line line, bool level, double* at_us) {
  struct hal_sim* sim = self;
  if (line == HAL_BLANK && !level) delay_light(sim);
  *at_us = now_us(sim);
  bool room = loop_back(sim, line, level, *at_us);
  if (line == HAL_BLANK) room = room && sim_light_blank(&sim->light, level, *at_us);
  if (line == HAL_LATCH) room = room && sim_light_latch(&sim->light, level, *at_us);
  if (line == HAL_TRIGGER) room = room && trigger(sim, level, *at_us);
  if (line == HAL_HEARTBEAT) sim->beat_us = *at_us;
  if (line == HAL_READY || line == HAL_BUZZER) signal_operator(sim, line, level, *at_us);
  if (line == HAL_LAMP) room = room && sim_light_lamp(&sim->light, level, *at_us);
  return room ? LAM_OK : fail(sim, "more happened in one burst than the simulated rig remembers");
}

static enum lam_status shift_leds(void* self, const uint8_t stream[CHAIN_BYTES],
                                  uint8_t pushed_out[CHAIN_BYTES], double* at_us) {
  struct hal_sim* sim = self;
  uint8_t wire[CHAIN_BYTES];
  if (sim->playing && sim->shift_count++ == sim->faults.broken_shift) {
    return fail(sim, "the LED chain's bus did not take a frame: look at its plug and wires");
  }
  memcpy(wire, stream, CHAIN_BYTES);
  const int bit = sim->faults.flipped_bit;
  if (bit >= 0) wire[bit / 8] ^= (uint8_t)(0x80 >> bit % 8);
  const int stuck = sim->faults.stuck_bit;
  if (stuck >= 0) wire[stuck / 8] |= (uint8_t)(0x80 >> stuck % 8);
  *at_us = now_us(sim);
  sim_chain_shift(&sim->light.chain, wire, CHAIN_BITS, pushed_out);
  wait_until_us(sim, *at_us + rig_shift_us(sim->rig));
  return LAM_OK;
}

static enum lam_status commit_pattern(void* self, struct hal_pattern pattern, double* at_us) {
  struct hal_sim* sim = self;
  *at_us = now_us(sim);
  if (sim->flip_pending) {
    return fail(
        sim,
        "a flip was committed before the last one happened: is the projector on and plugged "
        "in?");
  }
  sim->flip_pending = true;
  if (sim->faults.frozen_projector) return LAM_OK;
  const double vblank_us = next_vblank_us(sim, *at_us);
  return sim_light_flip(&sim->light, pattern, vblank_us)
             ? LAM_OK
             : fail(sim, "more flips in one burst than the simulated rig remembers");
}

static bool flipped(void* self, double* at_us) {
  struct hal_sim* sim = self;
  if (!sim->flip_pending || sim->faults.frozen_projector) return false;
  *at_us = sim->light.flips[sim->light.flip_count - 1].vblank_us;
  if (now_us(sim) < *at_us - 0.5) return false;
  sim->flip_pending = false;
  return true;
}

static enum lam_status move_analyser(void* self, bool crossed, double* at_us) {
  struct hal_sim* sim = self;
  *at_us = sim->moved_us = now_us(sim);
  sim->move_pending = true;
  if (sim->faults.stuck_actuator) return LAM_OK;
  const double duration_us = sim->rig->analyser_move_us * sim->faults.slow_actuator;
  return sim_light_move(&sim->light, crossed ? M_PI_2 : 0, *at_us, *at_us + duration_us)
             ? LAM_OK
             : fail(sim, "more analyser moves than the simulated rig remembers");
}

static bool arrived(void* self, double* at_us) {
  struct hal_sim* sim = self;
  if (!sim->move_pending || sim->faults.stuck_actuator) return false;
  *at_us = sim->light.moves[sim->light.move_count - 1].to_us;
  if (now_us(sim) < *at_us - 0.5) return false;
  sim->move_pending = false;
  return true;
}

static enum lam_status unread(struct hal_photograph* photograph, const char* text) {
  snprintf(photograph->error, sizeof photograph->error, "%s", text);
  return LAM_HARDWARE;
}

static bool is_missed(const struct hal_sim* sim, unsigned shot) {
  if ((int)shot == sim->faults.dropped_shot) return true;
  return shot >= __atomic_load_n(&sim->shot_count, __ATOMIC_ACQUIRE) || sim->shots[shot].missed;
}

static enum lam_status ask_twin(struct hal_sim* sim, unsigned shot, unsigned camera,
                                struct hal_photograph* photograph) {
  static lamella_v1_ExposureReport report;
  pthread_mutex_lock(&sim->light_lock);
  const bool whole = sim_light_report(&sim->light, camera, sim->shots[shot].open_us,
                                      sim->shots[shot].close_us, &report);
  pthread_mutex_unlock(&sim->light_lock);
  if (!whole) {
    return unread(photograph, "more light changes in one exposure than a report can hold");
  }
  return sim_twin_photograph(sim->twin_socket, &report, photograph) ? LAM_OK : LAM_HARDWARE;
}

static enum lam_status read_photograph(void* self, unsigned shot, unsigned camera,
                                       struct hal_photograph* photograph) {
  struct hal_sim* sim = self;
  if (sim->twin_socket < 0 && sim->frames.rows == NULL) {
    return unread(photograph, "there is no twin to take photographs");
  }
  if ((int)camera == sim->faults.missing_camera) {
    return unread(photograph, camera == 0
                                  ? "the left camera sends no frame: check its cable and power"
                                  : "the right camera sends no frame: check its cable and power");
  }
  if (is_missed(sim, shot)) {
    unread(photograph, "a camera missed a trigger");
    return LAM_DROPPED;
  }
  if (sim->frames.rows == NULL) return ask_twin(sim, shot, camera, photograph);
  return sim_frames_photograph(&sim->frames, sim->rig, (uint8_t)(2 * shot + camera), photograph);
}

// The monostable blanks by itself what no heart beats for. In a burst that is left out: the
// fixtures that play one there have no heart.
static void stop_heart(struct hal_sim* sim) {
  const double dark_us = sim->beat_us + kHoldUs;
  if (sim->playing || sim->faults.dead_monostable || now_us(sim) < dark_us) return;
  if (sim->light.blank) return;
  sim_light_blank(&sim->light, true, dark_us);
  loop_back(sim, HAL_BLANK, true, dark_us);
}

static bool next_seen(void* self, struct hal_seen_edge* edge) {
  struct hal_sim* sim = self;
  stop_heart(sim);
  if (sim->seen_given == sim->seen_count) return false;
  *edge = sim->seen[sim->seen_given++];
  return true;
}

// Its end stop has not come for half as long again as a move takes.
static bool is_stuck(const struct hal_sim* sim, double t_us) {
  return sim->move_pending && sim->faults.stuck_actuator &&
         t_us > sim->moved_us + 1.5 * sim->rig->analyser_move_us;
}

static enum lam_status sense(void* self, struct hal_senses* senses) {
  struct hal_sim* sim = self;
  const struct sim_faults* faults = &sim->faults;
  const double t_us = now_us(sim), analyser_rad = sim_light_analyser_rad(&sim->light, t_us);
  const double pressed_us = t_us - sim->opened_us - faults->press_us;
  const bool begun = faults->begin_us == 0 || t_us >= sim->zero_us + faults->begin_us;
  *senses = (struct hal_senses){
      .start_pressed = pressed_us >= 0 && pressed_us < faults->hold_us,
      .estopped = faults->estopped && begun,
      .at_parallel = analyser_rad<kEndStopRad, .at_crossed = analyser_rad> M_PI_2 - kEndStopRad,
      .stuck = is_stuck(sim, t_us),
      .hottest_c =
          isnan(faults->hottest_c) || !begun ? sim->rig->leds_ambient_c : faults->hottest_c};
  return LAM_OK;
}

static void close_rig(void* self) {
  struct hal_sim* sim = self;
  lights_off(sim);
  sim_twin_disconnect(sim->twin_socket);
  sim->twin_socket = -1;
  sim_frames_close(&sim->frames);
}

enum lam_status hal_sim_use_test_frames(struct hal_sim* sim) {
  const enum lam_status status = sim_frames_open(&sim->frames, sim->rig, sim->hal.error);
  sim->hal.reads_while_playing = status == LAM_OK;
  return status;
}

enum lam_status hal_sim_open(struct hal_sim* sim, const struct rig* rig, enum sim_clock clock,
                             struct sim_faults faults, const char* twin_path) {
  memset(sim, 0, sizeof *sim);
  sim->rig = rig;
  sim->clock = clock;
  sim->faults = faults;
  pthread_mutex_init(&sim->light_lock, NULL);
  sim_light_init(&sim->light, rig, &sim->faults);
  sim->last_vblank_us = sim->opened_us = now_us(sim);
  sim->hal = (struct hal){.name = "sim",
                          .self = sim,
                          .keeps_real_time = clock == SIM_CLOCK_REAL,
                          .now_us = now_us,
                          .wait_until_us = wait_until_us,
                          .prepare = prepare,
                          .arm = arm,
                          .resume = resume,
                          .set_line = set_line,
                          .shift_leds = shift_leds,
                          .commit_pattern = commit_pattern,
                          .flipped = flipped,
                          .move_analyser = move_analyser,
                          .arrived = arrived,
                          .read_photograph = read_photograph,
                          .next_seen = next_seen,
                          .sense = sense,
                          .lights_off = lights_off,
                          .close = close_rig};
  sim->twin_socket = -1;
  if (twin_path == NULL) return LAM_OK;
  sim->twin_socket = sim_twin_connect(twin_path, sim->hal.error, sizeof sim->hal.error);
  return sim->twin_socket >= 0 ? LAM_OK : LAM_HARDWARE;
}
