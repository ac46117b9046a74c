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

void selftest_tell(const struct selftest_reading* r, char text[SELFTEST_WHY_CHARS]) {
  char value[32] = "";
  const bool is_number = !isnan(r->value) && strcmp(r->unit, "yes/no") != 0;
  if (is_number) {
    snprintf(value, sizeof value, fabs(r->value) < 1e3 ? " %.4g %s" : " %.0f %s", r->value,
             r->unit);
  }
  snprintf(text, SELFTEST_WHY_CHARS, "%s%s%s%s", r->what, value, r->note[0] != '\0' ? ": " : "",
           r->note);
}

void selftest_condemn(struct selftest* test, enum selftest_part part, const char* why) {
  test->unfit |= 1u << part;
  snprintf(test->why[part], sizeof test->why[part], "%s", why);
}

static void acquit(struct selftest* test, enum selftest_part part) {
  if (part == SELFTEST_LEDS) test->needs_full = false;
  test->unfit &= ~(1u << part);
  test->why[part][0] = '\0';
}

// Of the part that was just tested; one that was only skipped stays what it was.
static void judge(struct selftest* test) {
  const struct selftest_reading* first_bad = NULL;
  bool good = false;
  for (size_t i = test->count; i > 0 && test->readings[i - 1].part == test->part; i--) {
    const struct selftest_reading* r = &test->readings[i - 1];
    if (r->verdict == SELFTEST_BAD) first_bad = r;
    good = good || r->verdict == SELFTEST_GOOD;
  }
  if (first_bad != NULL) {
    char why[SELFTEST_WHY_CHARS];
    selftest_tell(first_bad, why);
    selftest_condemn(test, test->part, why);
    if (test->part == SELFTEST_LEDS && !test->quick) test->needs_full = true;
  } else if (good) {
    acquit(test, test->part);
  }
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
  judge(test);
  test->part++;
  test->step = test->shots = 0;
  return true;
}

void selftest_abandon(struct selftest* test) {
  test->hal->lights_off(test->hal->self);
  test->running = false;
}

enum lam_part selftest_failed_part(const struct selftest* test) {
  for (int i = 0; i < SELFTEST_PARTS; i++) {
    if (test->unfit >> i & 1) return kParts[i].panel;
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
