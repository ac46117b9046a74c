#include "hal_sim_faults.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "hal_sim_light.h"
#include "led_chain.h"
#include "rig.h"

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

// A fault that is one whole number below `end`.
struct counted_fault {
  const char* name;
  size_t offset;
  int end;
};

static const struct counted_fault kCounted[] = {
    {"flip-bit", offsetof(struct sim_faults, flipped_bit), CHAIN_BITS},
    {"stuck-bit", offsetof(struct sim_faults, stuck_bit), CHAIN_BITS},
    {"missing-chip", offsetof(struct sim_faults, missing_chip), CHAIN_CHIPS},
    {"broken-chip", offsetof(struct sim_faults, broken_chip), CHAIN_CHIPS},
    {"forgetful-chip", offsetof(struct sim_faults, forgetful_chip), CHAIN_CHIPS},
    {"dead-led", offsetof(struct sim_faults, dead_led), RIG_MAX_LEDS},
    {"weak-led", offsetof(struct sim_faults, weak_led), RIG_MAX_LEDS},
    {"drop-frame", offsetof(struct sim_faults, dropped_shot), SIM_MAX_EVENTS},
    {"missing-camera", offsetof(struct sim_faults, missing_camera), 2},
    {"spi-error", offsetof(struct sim_faults, broken_shift), SIM_MAX_EVENTS},
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
    char* end = NULL;
    numbers[i] = strtod(at, &end);
    if (end == at || !(numbers[i] >= 0 && numbers[i] < 1e9)) return 0;
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
    return numbers[0] < kCounted[i].end;
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
    return true;
  }
  if (numbers_after(text, "swapped-leds", numbers) == 2) {
    faults->swapped_leds[0] = (int)numbers[0];
    faults->swapped_leds[1] = (int)numbers[1];
    return numbers[0] < RIG_MAX_LEDS && numbers[1] < RIG_MAX_LEDS;
  }
  if (numbers_after(text, "press", numbers) != 2) return false;
  faults->press_us = numbers[0];
  faults->hold_us = numbers[1];
  return true;
}
