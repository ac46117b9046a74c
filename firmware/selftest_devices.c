// The parts that have no light in them.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "burst.h"
#include "latency.h"
#include "led_driver.h"
#include "selftest.h"

static const double kPieceUs = 20e3;  // how long one piece may wait
static const double kLookUs = 500;    // how often something that is to happen is looked for
static const double kMostMoves = 3;   // a move that takes so many times its time does not arrive
static const double kMostRefreshes = 12;
enum { kCameras = 2 };

static const double kLeastFreeSessions = 2;

static double now_us(const struct selftest* test) { return test->hal->now_us(test->hal->self); }

static void note(struct selftest_reading* reading, const char* text) {
  snprintf(reading->note, sizeof reading->note, "%s", text);
}

static bool sense(struct selftest* test, struct hal_senses* senses) {
  if (test->hal->sense(test->hal->self, senses) == LAM_OK) return true;
  selftest_fail(test, "inputs", test->hal->error);
  return false;
}

bool selftest_estop(struct selftest* test) {
  struct hal_senses senses;
  if (!sense(test, &senses)) return false;
  struct selftest_reading* reading = selftest_read(test, "pressed", senses.estopped, "yes/no");
  if (senses.estopped) note(reading, "release the emergency stop; a broken wire reads the same");
  selftest_limit(test, reading, 0, 0);
  return false;
}

// A burst may heat a junction by as much as full power does.
bool selftest_temperature(struct selftest* test) {
  struct hal_senses senses;
  if (test->rig->board.given && test->rig->board.temperature_file[0] == '\0') {
    selftest_skip(test, "hottest thermistor", "the rig file names none");
    return false;
  }
  if (!sense(test, &senses)) return false;
  struct selftest_reading* reading =
      selftest_read(test, "hottest thermistor", senses.hottest_c, "C");
  selftest_limit(test, reading, -20, rig_hottest_board_c(test->rig));
  if (reading->verdict == SELFTEST_BAD)
    note(reading, "let the LEDs cool; or the thermistor is off");
  return false;
}

static void judge_bursts(struct selftest* test) {
  const double held = store_bursts_held(test->store);
  struct selftest_reading* bursts = selftest_read(test, "bursts held", held, "bursts");
  selftest_limit(test, bursts, 0, STORE_MAX_BURSTS - 1);
  if (bursts->verdict == SELFTEST_BAD) note(bursts, "sync sessions to a host to make room");
}

bool selftest_disk(struct selftest* test) {
  if (test->disk == NULL) {
    selftest_skip(test, "free space", "photographs are kept in memory alone");
    return false;
  }
  double free_bytes = 0, bytes_per_s = 0;
  char error[112];
  if (!test->disk->measure(test->disk->context, &free_bytes, &bytes_per_s, error)) {
    selftest_fail(test, "writing", error);
    return false;
  }
  const double needed = store_needed_bytes(kLeastFreeSessions * kCameras * BURST_STEPS,
                                           test->rig->camera_frame_bytes);
  struct selftest_reading* room = selftest_read(test, "free space", free_bytes * 1e-6, "MB");
  selftest_limit(test, room, needed * 1e-6, INFINITY);
  if (room->verdict == SELFTEST_BAD) {
    note(room, store_bursts_held(test->store) > 0 ? "sync sessions to a host to make room"
                                                  : "two bursts' room is asked: make some on it");
  }
  struct selftest_reading* rate = selftest_read(test, "write rate", bytes_per_s * 1e-6, "MB/s");
  selftest_limit(test, rate, test->rig->store_disk_bytes_per_s * 1e-6, INFINITY);
  if (rate->verdict == SELFTEST_BAD) note(rate, "slower than store.disk_bytes_per_s counts on");
  judge_bursts(test);
  return false;
}

static void judge_length(struct selftest* test) {
  const struct chain_trial* trial = &test->trial;
  const double chips = (double)trial->length / CHAIN_CHIP_BITS;
  struct selftest_reading* reading = selftest_read(test, "chips in the chain", chips, "chips");
  selftest_limit(test, reading, CHAIN_CHIPS, CHAIN_CHIPS);
  if (reading->verdict != SELFTEST_BAD) return;
  if (trial->all_zeros || trial->all_ones) {
    note(reading, "nothing comes back: power, data wire, or a chip that passes nothing on");
  } else if (trial->length == 0) {
    note(reading, "what comes back is not what went in: check clock, ground and SPI speed");
  } else {
    snprintf(reading->note, sizeof reading->note, "%d bits come back after, %d expected",
             trial->length, CHAIN_BITS);
  }
}

static void judge_bits(struct selftest* test) {
  const struct chain_trial* trial = &test->trial;
  struct selftest_reading* reading =
      selftest_read(test, "wrong bits", (double)trial->wrong, "bits");
  selftest_limit(test, reading, 0, 0);
  if (trial->first_wrong < 0) {
    snprintf(reading->note, sizeof reading->note, "of %ld", trial->compared);
    return;
  }
  int chip = 0, output = 0, bit = 0;
  chain_place(trial->first_wrong, &chip, &output, &bit);
  snprintf(reading->note, sizeof reading->note,
           "of %ld; first at bit %d of the stream: chip %d output %d bit %d", trial->compared,
           trial->first_wrong, chip, output, bit);
}

// What the drivers keep besides levels, written anew as the streams went over it.
static void judge_functions(struct selftest* test) {
  if (test->trial.length != CHAIN_BITS) {
    selftest_skip(test, "wrong function bits",
                  "the chain's length is wrong: so is every place in it");
    return;
  }
  struct led_functions functions;
  const enum lam_status status = led_driver_ready(test->hal, test->rig, &functions);
  if (functions.compared == 0 && status == LAM_OK) {
    selftest_skip(test, "wrong function bits", "a tlc5947 has no functions");
    return;
  }
  if (functions.wrong == 0 && status != LAM_OK) {
    selftest_fail(test, "wrong function bits", test->hal->error);
    return;
  }
  struct selftest_reading* reading =
      selftest_read(test, "wrong function bits", (double)functions.wrong, "bits");
  selftest_limit(test, reading, 0, 0);
  snprintf(reading->note, sizeof reading->note, "of %ld", functions.compared);
  if (functions.wrong > 0) {
    snprintf(reading->note, sizeof reading->note,
             "of %ld; chip %d is the first that does not keep them: its supply, LATCH",
             functions.compared, functions.first_chip);
  }
}

// No LATCH between the streams: what they hold must not become levels. The chain is left dark.
bool selftest_chain(struct selftest* test) {
  static const uint8_t kDark[CHAIN_BYTES];
  struct hal* hal = test->hal;
  uint8_t out[CHAIN_BYTES];
  double at_us = 0;
  if (test->step == 0) {
    hal->lights_off(hal->self);
    chain_trial_begin(&test->trial);
  }
  const bool over = test->step == CHAIN_TRIAL_STREAMS;
  const uint8_t* stream = over ? kDark : chain_trial_stream(&test->trial);
  if (hal->shift_leds(hal->self, stream, out, &at_us) != LAM_OK) {
    selftest_fail(test, "shifting", hal->error);
    return false;
  }
  if (!over) {
    chain_trial_take(&test->trial, out);
    return true;
  }
  judge_length(test);
  if (test->trial.length > 0) judge_bits(test);
  judge_functions(test);
  return false;
}

static bool has_end_stops(const struct rig* rig) {
  return !rig->board.given ||
         (rig->board.at_parallel_line[0] != '\0' && rig->board.at_crossed_line[0] != '\0');
}

static void judge_stop(struct selftest* test, bool crossed) {
  struct hal_senses senses;
  if (!has_end_stops(test->rig)) {
    selftest_skip(test, crossed ? "at crossed" : "at parallel", "the rig file names no end stops");
    return;
  }
  if (!sense(test, &senses)) return;
  const bool there =
      crossed ? senses.at_crossed && !senses.at_parallel : senses.at_parallel && !senses.at_crossed;
  struct selftest_reading* reading =
      selftest_read(test, crossed ? "at crossed" : "at parallel", there, "yes/no");
  selftest_limit(test, reading, 1, 1);
  if (!there) note(reading, "its end stop does not say so: free the polarizer, check the switch");
}

static void judge_move(struct selftest* test, bool crossed, double took_us) {
  struct selftest_reading* reading =
      selftest_read(test, crossed ? "move to crossed" : "move to parallel", took_us * 1e-3, "ms");
  selftest_limit(test, reading, 0, test->rig->analyser_move_us * 1.1e-3);
  if (reading->verdict == SELFTEST_BAD) note(reading, "slower than analyser.move_us");
}

// One move: started in an even step, awaited in odd ones. True while it is under way.
static bool await_arrival(struct selftest* test, bool crossed) {
  struct hal* hal = test->hal;
  double at_us = 0;
  for (double t_us = now_us(test), end_us = t_us + kPieceUs; t_us < end_us; t_us += kLookUs) {
    if (hal->arrived(hal->self, &at_us)) {
      judge_move(test, crossed, at_us - test->begun_us);
      hal->wait_until_us(hal->self, at_us + test->rig->analyser_settle_us);
      judge_stop(test, crossed);
      test->stands_crossed = crossed;
      return false;
    }
    hal->wait_until_us(hal->self, t_us + kLookUs);
  }
  if (now_us(test) - test->begun_us < kMostMoves * test->rig->analyser_move_us) return true;
  selftest_fail(test, crossed ? "move to crossed" : "move to parallel",
                "it does not arrive: free the polarizer, check the actuator's power");
  return false;
}

static bool start_move(struct selftest* test) {
  struct hal* hal = test->hal;
  if (hal->move_analyser(hal->self, !test->stands_crossed, &test->begun_us) == LAM_OK) return true;
  selftest_fail(test, "moving", hal->error);
  return false;
}

// To the other end and back.
bool selftest_actuator(struct selftest* test) {
  if (test->step == 0) {
    double zero_us = 0;
    if (test->hal->prepare(test->hal->self, &zero_us) != LAM_OK) {
      selftest_fail(test, "preparing", test->hal->error);
      return false;
    }
    test->worst_us = 0;  // moves that are over
    return start_move(test);
  }
  const bool stood_crossed = test->stands_crossed;
  if (await_arrival(test, !stood_crossed)) return true;
  if (test->stands_crossed == stood_crossed) return false;
  test->worst_us += 1;
  return test->worst_us < 2 && start_move(test);
}

static bool await_flip(struct selftest* test, double* at_us) {
  struct hal* hal = test->hal;
  const double end_us = now_us(test) + kMostRefreshes * rig_refresh_us(test->rig);
  while (now_us(test) < end_us) {
    if (hal->flipped(hal->self, at_us)) return true;
    hal->wait_until_us(hal->self, now_us(test) + kLookUs);
  }
  return false;
}

// Two flips of a dark lamp, some refreshes apart.
bool selftest_projector(struct selftest* test) {
  const struct hal_pattern black = {lamella_v1_PatternSpan_Kind_BLACK, 0};
  struct hal* hal = test->hal;
  const double refresh_us = rig_refresh_us(test->rig);
  double committed_us = 0, flip_us[2] = {0, 0};
  if (test->rig->board.given && test->rig->board.display_device[0] == '\0') {
    selftest_skip(test, "flip", "the rig file names no display");
    return false;
  }
  if (hal->arm(hal->self) != LAM_OK) {
    selftest_fail(test, "preparing", hal->error);
    return false;
  }
  for (int i = 0; i < 2; i++) {
    if (hal->commit_pattern(hal->self, black, &committed_us) != LAM_OK) {
      selftest_fail(test, "flip", hal->error);
      return false;
    }
    if (!await_flip(test, &flip_us[i])) {
      selftest_fail(test, "flip", "it does not happen: check the projector's cable and power");
      return false;
    }
  }
  struct selftest_reading* flip =
      selftest_read(test, "flip after commit", (flip_us[1] - committed_us) * 1e-3, "ms");
  selftest_limit(test, flip, 0, 2 * refresh_us * 1e-3);
  const double periods = fmax(1, round((flip_us[1] - flip_us[0]) / refresh_us));
  struct selftest_reading* rate =
      selftest_read(test, "refresh rate", 1e6 * periods / (flip_us[1] - flip_us[0]), "Hz");
  selftest_limit(test, rate, 0.99 * test->rig->projector_refresh_hz,
                 1.01 * test->rig->projector_refresh_hz);
  return false;
}

// One late edge is retaken; a rig where one in a hundred is late would retake all the time.
bool selftest_latency(struct selftest* test) {
  lamella_v1_Latency latency;
  latency_test(test->hal, &latency);
  selftest_read(test, "latest of 300 wake-ups", latency.highest_us, "us");
  struct selftest_reading* reading =
      selftest_read(test, "99 of 100 wake-ups", latency.p99_us, "us late");
  selftest_limit(test, reading, 0, test->rig->player_critical_tolerance_us);
  if (reading->verdict == SELFTEST_BAD) note(reading, "edges would come late: see linux.cpu");
  return false;
}
