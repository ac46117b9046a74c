#include "selftest.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

struct part {
  const char* name;
  bool (*work)(struct selftest* test);
  enum lam_part panel;
};

static const struct part kParts[SELFTEST_PARTS] = {
    [SELFTEST_ESTOP] = {"estop", selftest_estop, LAM_PART_ESTOP},
    [SELFTEST_TEMPERATURE] = {"temperature", selftest_temperature, LAM_PART_HEAT},
    [SELFTEST_DISK] = {"disk", selftest_disk, LAM_PART_DISK},
    [SELFTEST_CHAIN] = {"chain", selftest_chain, LAM_PART_LED_CHAIN},
    [SELFTEST_BLANK] = {"blank", selftest_blank, LAM_PART_LED_CHAIN},
    [SELFTEST_ACTUATOR] = {"actuator", selftest_actuator, LAM_PART_ACTUATOR},
    [SELFTEST_PROJECTOR] = {"projector", selftest_projector, LAM_PART_PROJECTOR},
    [SELFTEST_CAMERAS] = {"cameras", selftest_cameras, LAM_PART_CAMERA},
    [SELFTEST_LEDS] = {"leds", selftest_leds, LAM_PART_LED_CHAIN},
    [SELFTEST_LATENCY] = {"latency", selftest_latency, LAM_PART_OTHER},
};

const char* selftest_part_name(enum selftest_part part) {
  return part < SELFTEST_PARTS ? kParts[part].name : "?";
}

enum selftest_part selftest_part_named(const char* name) {
  for (int i = 0; i < SELFTEST_PARTS; i++) {
    if (strcmp(name, kParts[i].name) == 0) return (enum selftest_part)i;
  }
  return SELFTEST_PARTS;
}

void selftest_init(struct selftest* test, const struct rig* rig, struct hal* hal,
                   struct store* store) {
  memset(test, 0, sizeof *test);
  test->rig = rig;
  test->hal = hal;
  test->store = store;
  test->stands_crossed = rig->analyser_parks_crossed;
}

void selftest_begin(struct selftest* test, unsigned parts, bool quick, bool learning) {
  test->parts = parts;
  test->quick = quick;
  test->learning = learning;
  test->running = true;
  test->part = SELFTEST_ESTOP;
  test->step = 0;
  test->count = test->bad = 0;
  test->shots = 0;
}

bool selftest_work(struct selftest* test) {
  if (!test->running) return false;
  while (test->part < SELFTEST_PARTS && !(test->parts >> test->part & 1)) test->part++;
  if (test->part == SELFTEST_PARTS) {
    selftest_abandon(test);
    return false;
  }
  if (kParts[test->part].work(test)) {
    test->step++;
    return true;
  }
  test->part++;
  test->step = test->shots = 0;
  return true;
}

void selftest_abandon(struct selftest* test) {
  test->hal->lights_off(test->hal->self);
  test->running = false;
}

enum lam_part selftest_failed_part(const struct selftest* test) {
  for (size_t i = 0; i < test->count; i++) {
    if (test->readings[i].verdict == SELFTEST_BAD) return kParts[test->readings[i].part].panel;
  }
  return LAM_PART_OTHER;
}

// Where there are more than there is room for, the last one is written over: `bad` still counts.
struct selftest_reading* selftest_read(struct selftest* test, const char* what, double value,
                                       const char* unit) {
  if (test->count < SELFTEST_MAX_READINGS) test->count++;
  struct selftest_reading* reading = &test->readings[test->count - 1];
  *reading = (struct selftest_reading){
      .part = test->part, .value = value, .low = -INFINITY, .high = INFINITY};
  snprintf(reading->what, sizeof reading->what, "%s", what);
  snprintf(reading->unit, sizeof reading->unit, "%s", unit);
  return reading;
}

void selftest_limit(struct selftest* test, struct selftest_reading* reading, double low,
                    double high) {
  reading->low = low;
  reading->high = high;
  if (reading->value >= low && reading->value <= high) return;
  reading->verdict = SELFTEST_BAD;
  test->bad++;
}

void selftest_fail(struct selftest* test, const char* what, const char* note) {
  struct selftest_reading* reading = selftest_read(test, what, NAN, "");
  reading->verdict = SELFTEST_BAD;
  snprintf(reading->note, sizeof reading->note, "%s", note);
  test->bad++;
}

void selftest_skip(struct selftest* test, const char* what, const char* note) {
  struct selftest_reading* reading = selftest_read(test, what, NAN, "");
  reading->verdict = SELFTEST_SKIPPED;
  snprintf(reading->note, sizeof reading->note, "%s", note);
}
