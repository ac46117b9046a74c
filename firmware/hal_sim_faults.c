#include "hal_sim_faults.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "hal_sim_light.h"
#include "led_chain.h"
#include "roll.h"

const struct sim_faults kSimNoFaults = {.flipped_bit = -1,
                                        .stuck_bit = -1,
                                        .missing_chip = -1,
                                        .broken_chip = -1,
                                        .forgetful_chip = -1,
                                        .dead_led = -1,
                                        .weak_led = -1,
                                        .swapped_leds = {-1, -1},
                                        .late_pulse = -1,
                                        .dropped_shot = -1,
                                        .slow_actuator = 1,
                                        .missing_camera = -1,
                                        .broken_shift = -1,
                                        .hottest_c = NAN,
                                        .press_us = NAN};

static const char kLeds[] = "LEDs";  // as many as the rig has

// A fault that is a whole number below `end`: one of so many `what`.
struct counted_fault {
  const char* name;
  size_t offset;
  const char* what;
  int end;
};

static const struct counted_fault kCounted[] = {
    {"flip-bit", offsetof(struct sim_faults, flipped_bit), "bits", CHAIN_BITS},
    {"stuck-bit", offsetof(struct sim_faults, stuck_bit), "bits", CHAIN_BITS},
    {"missing-chip", offsetof(struct sim_faults, missing_chip), "chips", CHAIN_CHIPS},
    {"broken-chip", offsetof(struct sim_faults, broken_chip), "chips", CHAIN_CHIPS},
    {"forgetful-chip", offsetof(struct sim_faults, forgetful_chip), "chips", CHAIN_CHIPS},
    {"dead-led", offsetof(struct sim_faults, dead_led), kLeds, 0},
    {"weak-led", offsetof(struct sim_faults, weak_led), kLeds, 0},
    {"drop-frame", offsetof(struct sim_faults, dropped_shot), "shots of a burst", ROLL_MAX_SHOTS},
    {"missing-camera", offsetof(struct sim_faults, missing_camera), "cameras", 2},
    {"spi-error", offsetof(struct sim_faults, broken_shift), "LED frames of a burst",
     SIM_MAX_EVENTS},
};

// One that is a number, and one that is there or not.
struct named_fault {
  const char* name;
  size_t offset;
};

static const struct named_fault kSingle[] = {
    {"slow-actuator", offsetof(struct sim_faults, slow_actuator)},
    {"hot", offsetof(struct sim_faults, hottest_c)},
    {"begin", offsetof(struct sim_faults, begin_us)},
};

static const struct named_fault kPlain[] = {
    {"stuck-actuator", offsetof(struct sim_faults, stuck_actuator)},
    {"frozen-projector", offsetof(struct sim_faults, frozen_projector)},
    {"dead-monostable", offsetof(struct sim_faults, dead_monostable)},
    {"estop", offsetof(struct sim_faults, estopped)},
};

enum { kMostNumbers = 2 };

// The numbers after "NAME:", with another colon between two; how many there are, 0 where it is not
// so.
static int numbers_after(const char* text, const char* name, double numbers[kMostNumbers]) {
  const size_t length = strlen(name);
  if (strncmp(text, name, length) != 0 || text[length] != ':') return 0;
  const char* at = text + length + 1;
  for (int i = 0; i < kMostNumbers; i++) {
    const char* end = rig_text_number(at, &numbers[i]);
    if (end == NULL || !(numbers[i] >= 0 && numbers[i] < 1e9)) return 0;
    if (*end == '\0') return i + 1;
    if (*end != ':') return 0;
    at = end + 1;
  }
  return 0;
}

static bool parse_counted(const char* text, struct sim_faults* faults) {
  for (size_t i = 0; i < sizeof kCounted / sizeof kCounted[0]; i++) {
    double numbers[kMostNumbers];
    if (numbers_after(text, kCounted[i].name, numbers) != 1) continue;
    *(int*)((char*)faults + kCounted[i].offset) = (int)numbers[0];
    return numbers[0] == floor(numbers[0]);
  }
  return false;
}

static bool parse_plain(const char* text, struct sim_faults* faults) {
  for (size_t i = 0; i < sizeof kPlain / sizeof kPlain[0]; i++) {
    if (strcmp(text, kPlain[i].name) != 0) continue;
    *(bool*)((char*)faults + kPlain[i].offset) = true;
    return true;
  }
  return false;
}

static bool parse_single(const char* text, struct sim_faults* faults) {
  for (size_t i = 0; i < sizeof kSingle / sizeof kSingle[0]; i++) {
    double numbers[kMostNumbers];
    if (numbers_after(text, kSingle[i].name, numbers) != 1) continue;
    *(double*)((char*)faults + kSingle[i].offset) = numbers[0];
    return true;
  }
  return false;
}

bool sim_faults_parse(const char* text, struct sim_faults* faults) {
  double numbers[kMostNumbers];
  if (parse_plain(text, faults) || parse_counted(text, faults)) return true;
  if (parse_single(text, faults)) return faults->slow_actuator > 0;
  const int lateness = numbers_after(text, "late-blank", numbers);
  if (lateness > 0) {
    faults->late_blank_us = numbers[0];
    faults->late_pulse = lateness > 1 ? (int)numbers[1] : -1;
    return lateness == 1 || numbers[1] == floor(numbers[1]);
  }
  if (numbers_after(text, "swapped-leds", numbers) == 2) {
    faults->swapped_leds[0] = (int)numbers[0];
    faults->swapped_leds[1] = (int)numbers[1];
    return numbers[0] == floor(numbers[0]) && numbers[1] == floor(numbers[1]);
  }
  if (numbers_after(text, "press", numbers) != 2) return false;
  faults->press_us = numbers[0];
  faults->hold_us = numbers[1];
  return true;
}

// As sim_faults_kind(), with how that fault is given: "dead-led:N" for "dead-led:x".
static int find_usage(const char* text, char usage[48]) {
  static const char kBlank[] = " \n";
  const size_t name = strcspn(text, ":");
  const char* at = SIM_FAULT_NAMES;
  at += strspn(at, kBlank);
  for (int kind = 0; *at != '\0'; kind++) {
    const size_t length = strcspn(at, kBlank);
    const bool same = strncmp(at, text, name) == 0 && strchr(": \n", at[name]) != NULL;
    if (same) snprintf(usage, 48, "%.*s", (int)length, at);
    if (same) return kind;
    at += length;
    at += strspn(at, kBlank);
  }
  return -1;
}

int sim_faults_kind(const char* text) {
  char usage[48];
  return find_usage(text, usage);
}

void sim_faults_explain(const char* text, char why[160]) {
  char usage[48];
  const char* colon = strchr(text, ':');
  if (find_usage(text, usage) >= 0) {
    snprintf(why, 160, "\"%.60s\" is no argument of %s", colon != NULL ? colon + 1 : "", usage);
  } else {
    snprintf(why, 160, "no such fault");
  }
}

static bool refuse(char error[160], const char* fault, const char* what, int end) {
  snprintf(error, 160, "--inject %s: %s are 0 to %d", fault, what, end - 1);
  return false;
}

static bool swap_fits(const int leds[2], int led_count, char error[160]) {
  char fault[48];
  snprintf(fault, sizeof fault, "swapped-leds:%d:%d", leds[0], leds[1]);
  if (leds[0] >= led_count || leds[1] >= led_count) return refuse(error, fault, kLeds, led_count);
  if (leds[0] < 0 || leds[0] != leds[1]) return true;
  snprintf(error, 160, "--inject %s: it takes two LEDs", fault);
  return false;
}

bool sim_faults_fit(const struct sim_faults* faults, const struct rig* rig, char error[160]) {
  char fault[64];
  const int led_count = (int)rig->led_count;
  for (size_t i = 0; i < sizeof kCounted / sizeof kCounted[0]; i++) {
    const struct counted_fault* counted = &kCounted[i];
    const int number = *(const int*)((const char*)faults + counted->offset);
    const int end = counted->what == kLeds ? led_count : counted->end;
    snprintf(fault, sizeof fault, "%s:%d", counted->name, number);
    if (number >= end) return refuse(error, fault, counted->what, end);
  }
  if (faults->late_pulse >= ROLL_MAX_SHOTS) {
    snprintf(fault, sizeof fault, "late-blank:%g:%d", faults->late_blank_us, faults->late_pulse);
    return refuse(error, fault, "pulses of a burst", ROLL_MAX_SHOTS);
  }
  return swap_fits(faults->swapped_leds, led_count, error);
}
