// The parts that photograph: cameras in the dark, then LED after LED.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "led_driver.h"
#include "selftest.h"

enum { kShotsInARow = 24, kDarkShots = 2 };
static const double kBeatUs = 2000;
static const double kMostDarkDn = 24;  // above black: 0.6 % of full scale
static const double kDeadShare = 0.1;  // of what is expected
static const double kWeakShare = 0.8, kStrongShare = 1.25;
static const double kSuspectShare = 0.1;   // of one LED, in the light of a whole chip
static const double kStrangeShare = 0.04;  // farther from its own reference than noise
// The cameras look from +Z (cos 1). What an LED lights that stands farther round than 135 degrees
// they hardly see: of a matt ball in the middle less than a sixth of the middle LED's light.
static const double kBehindCos = -0.7;

static double now_us(const struct selftest* test) { return test->hal->now_us(test->hal->self); }

// The monostable that holds BLANK up by itself wants to hear that the sequencer is alive.
static void beat_until(struct selftest* test, double t_us) {
  struct hal* hal = test->hal;
  double at_us = 0;
  while (now_us(test) + kBeatUs < t_us) {
    test->heart = !test->heart;
    hal->set_line(hal->self, HAL_HEARTBEAT, test->heart, &at_us);
    hal->wait_until_us(hal->self, now_us(test) + kBeatUs);
  }
}

static bool edge(struct selftest* test, double t_us, enum hal_line line, bool level) {
  double at_us = 0;
  test->hal->wait_until_us(test->hal->self, t_us);
  return test->hal->set_line(test->hal->self, line, level, &at_us) == LAM_OK;
}

static bool load(struct selftest* test, const uint16_t codes[]) {
  struct hal* hal = test->hal;
  uint8_t stream[CHAIN_BYTES];
  double at_us = 0;
  led_chain_encode(test->rig, codes, stream);
  if (hal->shift_leds(hal->self, stream, NULL, &at_us) != LAM_OK) return false;
  const double latch_us = now_us(test);
  return edge(test, latch_us, HAL_LATCH, true) &&
         edge(test, latch_us + test->rig->leds_latch_us, HAL_LATCH, false);
}

// One exposure as in a burst: the same light time, which keeps to the rules of duty by pauses.
static bool expose(struct selftest* test, bool lit) {
  const struct rig* rig = test->rig;
  const double trigger_us = fmax(now_us(test) + 100, test->dark_until_us);
  const double on_us = trigger_us + rig->camera_start_delay_us + rig->camera_guard_us;
  const double off_us = on_us + rig->leds_light_us;
  const double untrigger_us = trigger_us + rig->leds_light_us + 2 * rig->camera_guard_us;
  bool done = edge(test, trigger_us, HAL_TRIGGER, true);
  beat_until(test, trigger_us + kBeatUs);  // fresh when the light comes
  done = done && (!lit || edge(test, on_us, HAL_BLANK, false));
  beat_until(test, fmin(off_us, untrigger_us));
  if (rig->camera_start_delay_us > rig->camera_guard_us) {
    done = edge(test, untrigger_us, HAL_TRIGGER, false) && done;
    done = edge(test, off_us, HAL_BLANK, true) && done;
  } else {
    done = edge(test, off_us, HAL_BLANK, true) && done;
    done = edge(test, untrigger_us, HAL_TRIGGER, false) && done;
  }
  const double pause_us = lit ? rig->leds_light_us * (1 / rig->leds_highest_duty - 1) : 0;
  const double close_us = untrigger_us + rig->camera_start_delay_us;
  test->dark_until_us = fmax(off_us + pause_us,
                             close_us + rig->camera_readout_us + rig->player_critical_tolerance_us);
  test->hal->wait_until_us(test->hal->self, close_us + rig->camera_readout_us);
  return done;
}

static bool read_shot(struct selftest* test, unsigned camera, struct hal_photograph* photograph,
                      struct led_signature* seen) {
  photograph->bytes = store_room(test->store, &photograph->capacity);
  photograph->error[0] = '\0';
  if (test->hal->read_photograph(test->hal->self, test->shots, camera, photograph) != LAM_OK) {
    selftest_fail(test, camera == 0 ? "left camera" : "right camera", photograph->error);
    return false;
  }
  if (led_signature_take(seen, camera, photograph)) return true;
  selftest_fail(test, camera == 0 ? "left camera" : "right camera",
                "its frame has another size than its header says");
  return false;
}

// A photograph of both cameras under these codes; NULL: in the dark.
static bool photograph(struct selftest* test, const uint16_t codes[], struct led_signature* seen,
                       struct hal_photograph raw[2]) {
  struct hal* hal = test->hal;
  if (test->shots % kShotsInARow == 0) {
    test->shots = 0;
    if (hal->arm(hal->self) != LAM_OK) {
      selftest_fail(test, "preparing", hal->error);
      return false;
    }
  }
  if ((codes != NULL && !load(test, codes)) || !expose(test, codes != NULL)) {
    hal->lights_off(hal->self);
    selftest_fail(test, "exposing", hal->error);
    return false;
  }
  const bool seen_by_both = read_shot(test, 0, &raw[0], seen) && read_shot(test, 1, &raw[1], seen);
  test->shots++;
  return seen_by_both;
}

static double mean_dn(const struct led_signature* seen, unsigned camera) {
  double sum = 0;  // tents add up to one everywhere
  const int size = SIGNATURE_SIDE * SIGNATURE_SIDE;
  for (int i = 0; i < size; i++) sum += seen->dn[(int)camera * size + i];
  return sum;
}

static bool names_cameras(const struct rig_linux* board) {
  return !board->given || (board->camera_left[0] != '\0' && board->camera_right[0] != '\0');
}

// Two frames in the dark: each trigger gives one, as dark as black.
bool selftest_cameras(struct selftest* test) {
  struct led_signature seen;
  struct hal_photograph raw[2];
  if (!names_cameras(&test->rig->board)) {
    selftest_skip(test, "frames", "the rig file names no two cameras");
    return false;
  }
  if (!photograph(test, NULL, &seen, raw)) return false;
  if (test->step + 1 < kDarkShots) return true;
  struct selftest_reading* frames =
      selftest_read(test, "frames of two triggers", kDarkShots, "frames");
  selftest_limit(test, frames, kDarkShots, kDarkShots);
  for (unsigned camera = 0; camera < 2; camera++) {
    const double dark_dn = mean_dn(&seen, camera) - raw[camera].header.black_level_dn;
    struct selftest_reading* reading = selftest_read(
        test, camera == 0 ? "left, dark above black" : "right, dark above black", dark_dn, "dn");
    selftest_limit(test, reading, -kMostDarkDn, kMostDarkDn);
  }
  return false;
}

static void name_led(const struct selftest* test, size_t led, char name[48]) {
  const struct led_place* place = &test->rig->leds[led];
  snprintf(name, 48, "LED %zu (chip %u output %u)", led, place->chip, place->output);
}

static void blame(struct selftest* test, size_t led, double share, const char* note) {
  char name[48];
  name_led(test, led, name);
  struct selftest_reading* reading = selftest_read(test, name, share, "of expected");
  reading->low = kWeakShare;
  reading->high = kStrongShare;
  reading->verdict = SELFTEST_BAD;
  snprintf(reading->note, sizeof reading->note, "%s", note);
  test->bad++;
  test->blamed++;
}

// The LED whose reference is nearest.
static size_t nearest(const struct selftest* test, const struct led_signature* seen) {
  size_t best = 0;
  for (size_t i = 1; i < test->rig->led_count; i++) {
    if (led_signature_distance(seen, &test->reference.leds[i]) <
        led_signature_distance(seen, &test->reference.leds[best])) {
      best = i;
    }
  }
  return best;
}

// From `own` to what was seen, at the same brightness: an LED that is weak lights what it always
// lit.
static double shape_distance(const struct led_signature* seen, const struct led_signature* own,
                             double share) {
  struct led_signature as_bright = *seen;
  for (size_t i = 0; i < SIGNATURE_SIZE; i++) as_bright.dn[i] /= share;
  return led_signature_distance(&as_bright, own);
}

static void judge_led(struct selftest* test, size_t led, const struct led_signature* seen) {
  const struct led_signature* own = &test->reference.leds[led];
  const double expected = led_signature_norm(own);
  if (expected == 0) return;  // hidden when it was learned
  const double share = led_signature_norm(seen) / expected;
  const double distance = led_signature_distance(seen, own) / expected;
  const double turned = share > 0 ? shape_distance(seen, own, share) / expected : 0;
  const size_t other = nearest(test, seen);
  const double other_distance =
      led_signature_distance(seen, &test->reference.leds[other]) / expected;
  if (share < kDeadShare) {
    blame(test, led, share, "dead: check its wire, its power stage and the driver's output");
  } else if (other != led && turned > kStrangeShare && other_distance < distance / 2) {
    char note[112];
    snprintf(note, sizeof note, "lights up as LED %zu (chip %u output %u) should: swapped wires",
             other, test->rig->leds[other].chip, test->rig->leds[other].output);
    blame(test, led, share, note);
  } else if (share < kWeakShare || share > kStrongShare) {
    blame(test, led, share, share < 1 ? "weak: dirt, heat, or its power stage" : "too bright");
  }
}

static bool sums_up(struct selftest* test, int chip, const struct led_signature* seen) {
  struct led_signature rest = *seen;
  double brightest = 0;
  for (size_t i = 0; i < test->rig->led_count; i++) {
    if (test->rig->leds[i].chip != chip) continue;
    led_signature_add(&rest, -1, &test->reference.leds[i]);
    brightest = fmax(brightest, led_signature_norm(&test->reference.leds[i]));
  }
  return led_signature_norm(&rest) <= kSuspectShare * brightest;
}

static int by_size(const void* a, const void* b) {
  const double x = *(const double*)a, y = *(const double*)b;
  return (x > y) - (x < y);
}

// An LED that lights nothing the cameras see may be behind the subject: only eyes can tell.
static void leave_to_eyes(struct selftest* test, size_t led, const char* note) {
  char name[48];
  name_led(test, led, name);
  selftest_skip(test, name, note);
  test->unseen++;
}

static bool is_behind(const struct led_place* led) { return led->direction[2] < kBehindCos; }

// Without a reference an LED is dead where it gives far less light than the middle one, and stands
// where the cameras must see it. One that is learned as dark has an empty reference, and later
// tests leave it out.
static void judge_unlearned(struct selftest* test) {
  const size_t count = test->rig->led_count;
  double sorted[RIG_MAX_LEDS];
  memcpy(sorted, test->brightness, count * sizeof *sorted);
  qsort(sorted, count, sizeof *sorted, by_size);
  const double middle = fmax(sorted[count / 2], 1e-3);
  for (size_t i = 0; i < count; i++) {
    const double share = test->brightness[i] / middle;
    if (share >= kDeadShare) continue;
    if (test->learning) {
      test->reference.leds[i] = (struct led_signature){{0}};
      leave_to_eyes(test, i, "hidden from both cameras, or dead: look whether it lights up");
    } else if (is_behind(&test->rig->leds[i])) {
      leave_to_eyes(test, i, "behind what the cameras see: not judged, look whether it lights up");
    } else {
      blame(test, i, share, "dead, or hidden from both cameras: against the middle one of all");
    }
  }
}

static void keep_reference(struct selftest* test) {
  char error[112];
  test->reference.led_count = (uint32_t)test->rig->led_count;
  if (test->reference_path == NULL) {
    selftest_skip(test, "reference", "learned, and forgotten when the rig is switched off");
  } else if (led_reference_write(test->reference_path, &test->reference, error) != LAM_OK) {
    selftest_fail(test, "reference", error);
  } else {
    selftest_skip(test, "reference", "learned and kept");
  }
}

// LEDs that were hidden when they were learned.
static size_t count_unlearned(const struct selftest* test) {
  size_t count = 0;
  for (size_t i = 0; i < test->rig->led_count; i++) {
    count += led_signature_norm(&test->reference.leds[i]) == 0;
  }
  return count;
}

static bool finish_leds(struct selftest* test) {
  const bool learned = test->reference.led_count > 0;
  if (!learned || test->learning) {
    judge_unlearned(test);
  } else {
    test->unseen = count_unlearned(test);
  }
  if (test->learning) keep_reference(test);
  if (!learned && !test->learning) {
    selftest_skip(test, "reference", "none: dead LEDs alone are told; --learn on a good rig");
  }
  const size_t judged = test->rig->led_count - test->unseen;
  struct selftest_reading* reading =
      selftest_read(test, "LEDs as expected", (double)(judged - test->blamed), "LEDs");
  reading->low = reading->high = (double)judged;
  reading->verdict = test->blamed > 0 ? SELFTEST_BAD : SELFTEST_GOOD;
  if (test->unseen > 0) {
    snprintf(reading->note, sizeof reading->note,
             "of %zu; not judged, as no camera sees their light: %zu", test->rig->led_count,
             test->unseen);
  }
  return false;
}

static bool skip_leds(struct selftest* test) {
  struct hal_senses senses;
  if (test->hal->sense(test->hal->self, &senses) == LAM_OK && senses.estopped) {
    selftest_skip(test, "LEDs", "the emergency stop cuts their supply");
    return true;
  }
  if (!names_cameras(&test->rig->board)) {
    selftest_skip(test, "LEDs", "the rig file names no two cameras");
    return true;
  }
  if (test->quick && test->reference.led_count == 0) {
    selftest_skip(test, "LEDs", "no reference yet: lamella rig selftest --only leds --learn");
    return true;
  }
  return false;
}

static bool test_chip(struct selftest* test, int chip) {
  uint16_t codes[RIG_MAX_LEDS] = {0};
  struct led_signature seen;
  struct hal_photograph raw[2];
  for (size_t i = 0; i < test->rig->led_count; i++) {
    codes[i] = test->rig->leds[i].chip == chip ? CHAIN_FULL_CODE : 0;
  }
  if (!photograph(test, codes, &seen, raw)) return false;
  led_signature_add(&seen, -1, &test->dark);
  test->suspect[chip] = !sums_up(test, chip, &seen);
  return true;
}

static bool test_led(struct selftest* test, size_t led) {
  uint16_t codes[RIG_MAX_LEDS] = {0};
  struct led_signature seen;
  struct hal_photograph raw[2];
  codes[led] = CHAIN_FULL_CODE;
  if (!photograph(test, codes, &seen, raw)) return false;
  led_signature_add(&seen, -1, &test->dark);
  test->brightness[led] = led_signature_norm(&seen);
  if (test->learning) {
    test->reference.leds[led] = seen;
  } else if (test->reference.led_count > 0) {
    judge_led(test, led, &seen);
  }
  return true;
}

static bool has_functions(struct selftest* test) {
  struct led_functions functions;
  if (led_driver_ready(test->hal, test->rig, &functions) == LAM_OK) return true;
  selftest_fail(test, "LEDs", test->hal->error);
  return false;
}

// Dark, chip after chip, then LED after LED of the chips that are not as expected.
bool selftest_leds(struct selftest* test) {
  const unsigned chips = test->quick && !test->learning ? CHAIN_CHIPS : 0;
  if (test->step == 0) {
    struct hal_photograph raw[2];
    if (skip_leds(test) || !has_functions(test)) return false;
    test->blamed = test->unseen = 0;
    for (int i = 0; i < CHAIN_CHIPS; i++) test->suspect[i] = chips == 0;
    return photograph(test, NULL, &test->dark, raw);
  }
  if (test->step <= chips) return test_chip(test, (int)test->step - 1);
  size_t led = test->step - 1 - chips;
  while (led < test->rig->led_count && !test->suspect[test->rig->leds[led].chip]) led++;
  if (led == test->rig->led_count) return finish_leds(test);
  test->step = (unsigned)led + 1 + chips;
  return test_led(test, led);
}
