#include "latency.h"

#include <stdlib.h>

enum { kWaits = 300 };
static const double kApartUs = 1000;  // far enough that every wait begins with a sleep

static int compare(const void* a, const void* b) {
  const double difference = *(const double*)a - *(const double*)b;
  return (difference > 0) - (difference < 0);
}

void latency_test(struct hal* hal, lamella_v1_Latency* latency) {
  double late_us[kWaits];
  double due_us = hal->now_us(hal->self);
  for (int i = 0; i < kWaits; i++) {
    due_us += kApartUs;
    hal->wait_until_us(hal->self, due_us);
    const double woke_us = hal->now_us(hal->self);
    late_us[i] = woke_us - due_us;
    // A wait that ended very late must not make the next ones look late.
    if (woke_us > due_us + kApartUs / 2) due_us = woke_us;
  }
  qsort(late_us, kWaits, sizeof late_us[0], compare);
  *latency = (lamella_v1_Latency){.waits = kWaits,
                                  .median_us = late_us[kWaits / 2],
                                  .p99_us = late_us[kWaits * 99 / 100],
                                  .highest_us = late_us[kWaits - 1]};
}
