// bench_player RIG BURSTS: plays the bursts of a rig file on this machine's clock, as a board's
// player waits (hal_linux_time) and with its settings; lines are not there and take no time. Writes
// how late each edge was, in microseconds, one a line. Exit 2 bad input, 3 a burst failed.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "hal_linux_time.h"
#include "player.h"

enum { kBadInput = 2, kFailed = 3 };
static const double kPauseUs = 5000;
static double spin_us;

static double now_us(void* self) {
  (void)self;
  return linux_now_us();
}

static double wait_until_us(void* self, double t_us) {
  (void)self;
  return linux_wait_until_us(t_us, spin_us);
}

static enum lam_status prepare(void* self, double* zero_us) {
  *zero_us = now_us(self) + kPauseUs;
  return LAM_OK;
}

static enum lam_status set_line(void* self, enum hal_line line, bool level, double* at_us) {
  (void)line, (void)level;
  *at_us = now_us(self);
  return LAM_OK;
}

static enum lam_status shift_leds(void* self, const uint8_t stream[CHAIN_BYTES],
                                  uint8_t pushed_out[CHAIN_BYTES], double* at_us) {
  (void)stream, (void)pushed_out;
  *at_us = now_us(self);
  return LAM_OK;
}

static enum lam_status commit_pattern(void* self, struct hal_pattern pattern, double* at_us) {
  (void)pattern;
  *at_us = now_us(self);
  return LAM_OK;
}

static enum lam_status move_analyser(void* self, bool crossed, double* at_us) {
  (void)crossed;
  *at_us = now_us(self);
  return LAM_OK;
}

static bool is_seen(void* self, double* at_us) {
  *at_us = now_us(self);
  return true;
}

static bool next_seen(void* self, struct hal_seen_edge* edge) {
  (void)self, (void)edge;
  return false;
}

static void lights_off(void* self) { (void)self; }

static struct hal no_hardware = {.name = "none",
                                 .keeps_real_time = true,
                                 .now_us = now_us,
                                 .wait_until_us = wait_until_us,
                                 .prepare = prepare,
                                 .set_line = set_line,
                                 .shift_leds = shift_leds,
                                 .commit_pattern = commit_pattern,
                                 .flipped = is_seen,
                                 .move_analyser = move_analyser,
                                 .arrived = is_seen,
                                 .next_seen = next_seen,
                                 .lights_off = lights_off};

static enum lam_status play(const struct rig* rig, bool crossed) {
  static struct player player;
  static struct burst_plan plan;
  static struct timeline timeline;
  burst_order(rig, kBurstSteps, BURST_STEPS, crossed, &plan);
  timeline_build(rig, &plan, &timeline);
  enum lam_status status = player_start(&player, &no_hardware, rig, &plan, &timeline);
  while (status == LAM_OK && !player_is_done(&player)) status = player_step(&player);
  for (size_t i = 0; status == LAM_OK && i < timeline.count; i++) {
    const enum edge_line line = timeline.edges[i].line;
    if (line == EDGE_VBLANK || line == EDGE_ARRIVED) continue;
    printf("%.3f\n", player.played[i].actual_us - timeline.edges[i].t_us);
  }
  return status;
}

int main(int argc, char** argv) {
  static struct rig rig;
  const int bursts = argc == 3 ? atoi(argv[2]) : 0;
  if (bursts < 1) {
    fprintf(stderr, "usage: bench_player RIG BURSTS\n");
    return kBadInput;
  }
  if (rig_read(argv[1], &rig) != LAM_OK) return kBadInput;
  spin_us = rig.board.spin_us;
  int latency_fd = -1;
  char error[160];
  linux_time_settle(&rig.board, &latency_fd);
  if (linux_memory_lock(error) != LAM_OK) fprintf(stderr, "bench_player: %s\n", error);
  for (int i = 0; i < bursts; i++) {
    if (play(&rig, i % 2 == 1) == LAM_OK) continue;
    fprintf(stderr, "bench_player: burst %d: %s\n", i + 1, no_hardware.error);
    return kFailed;
  }
  return 0;
}
