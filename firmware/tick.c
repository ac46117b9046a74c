#include "tick.h"

#include <math.h>

// An interrupt takes some microseconds, and hal->tick_at_us is known to as many.
static const double kBeforeUs = 4, kAfterUs = 25;

bool tick_meets_edge(const struct hal* hal, const struct timeline* timeline, double zero_us) {
  if (!(hal->tick_us > 0)) return false;
  for (size_t i = 0; i < timeline->count; i++) {
    const struct edge* edge = &timeline->edges[i];
    if (edge->line != EDGE_BLANK && edge->line != EDGE_TRIGGER) continue;
    const double since_us = fmod(zero_us + edge->t_us - hal->tick_at_us, hal->tick_us);
    const double after_us = since_us < 0 ? since_us + hal->tick_us : since_us;
    if (after_us < kAfterUs || after_us > hal->tick_us - kBeforeUs) return true;
  }
  return false;
}
