#include "latency.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

enum { kWaits = 300, kSets = 100 };
static const double kApartUs = 1000;  // far enough that every wait begins with a sleep
// A kernel that takes longer is disturbed: nothing is ever early by more than this.
static const double kLongestLeadUs = 5;

static int compare(const void* a, const void* b) {
  const double difference = *(const double*)a - *(const double*)b;
  return (difference > 0) - (difference < 0);
}

static double median(double values[], int count) {
  qsort(values, (size_t)count, sizeof values[0], compare);
  return count > 0 ? values[count / 2] : 0;
}

// False where no edge of TRIGGER was seen since.
static bool hear_trigger(struct hal* hal, double since_us, double* took_us) {
  struct hal_seen_edge seen;
  bool heard = false;
  while (hal->next_seen(hal->self, &seen)) {
    if (seen.line != HAL_TRIGGER || seen.at_us < since_us) continue;
    heard = true;
    *took_us = seen.at_us - since_us;
  }
  return heard;
}

// An edge may be told of a while after it happened: it is asked for when the next one is due.
static double measure_by_loopback(struct hal* hal) {
  double took_us[kSets];
  int count = 0;
  double due_us = hal->now_us(hal->self), set_us = due_us, at_us = 0;
  for (int i = 0; i <= kSets; i++) {
    const double now_us = hal->wait_until_us(hal->self, due_us += kApartUs);
    if (i > 0 && hear_trigger(hal, set_us, &took_us[count])) count++;
    set_us = now_us;
    if (i < kSets) hal->set_line(hal->self, HAL_TRIGGER, i % 2 == 0, &at_us);
  }
  return median(took_us, count);
}

static double measure_by_calls(struct hal* hal) {
  double took_us[kSets];
  double due_us = hal->now_us(hal->self);
  for (int i = 0; i < kSets; i++) {
    const double set_us = hal->wait_until_us(hal->self, due_us += kApartUs);
    double at_us = set_us;
    hal->set_line(hal->self, HAL_LATCH, false, &at_us);
    took_us[i] = (at_us - set_us) / 2;
  }
  return median(took_us, kSets);
}

static void measure_waits(struct hal* hal, lamella_v1_Latency* latency) {
  double late_us[kWaits];
  double due_us = hal->now_us(hal->self);
  for (int i = 0; i < kWaits; i++) {
    due_us += kApartUs;
    const double woke_us = hal->wait_until_us(hal->self, due_us);
    late_us[i] = woke_us - due_us;
    // A wait that ended very late must not make the next ones look late.
    if (woke_us > due_us + kApartUs / 2) due_us = woke_us;
  }
  latency->waits = kWaits;
  latency->median_us = median(late_us, kWaits);
  latency->p99_us = late_us[kWaits * 99 / 100];
  latency->highest_us = late_us[kWaits - 1];
}

void latency_test(struct hal* hal, lamella_v1_Latency* latency) {
  const double took_us = hal->sees_trigger ? measure_by_loopback(hal) : measure_by_calls(hal);
  hal->lead_us = fmin(took_us, kLongestLeadUs);
  latency->lead_us = hal->lead_us;
  measure_waits(hal, latency);
}
