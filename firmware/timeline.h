// Time as data: everything a burst does, as edges {t_us, line, value} in the order they are due.
// The same array is checked (safety.h), played (player.h) and sent to the host as timing.json.
#ifndef LAMELLA_FIRMWARE_TIMELINE_H
#define LAMELLA_FIRMWARE_TIMELINE_H

#include <stddef.h>
#include <stdint.h>

#include "burst.h"
#include "rig.h"

enum { TIMELINE_MAX_EDGES = BURST_MAX_STEPS * 10 + 2 };

enum edge_line {
  EDGE_SHIFT,  // the step's codes go into the driver chain
  EDGE_LATCH,
  EDGE_BLANK,
  EDGE_TRIGGER,
  EDGE_LAMP,
  EDGE_COMMIT,    // the step's pattern is given to the display
  EDGE_VBLANK,    // observed: the display flipped to it
  EDGE_ANALYSER,  // the actuator starts; value 1 towards crossed
  EDGE_ARRIVED,   // observed: it stands still
  EDGE_LINES,
};

struct edge {
  double t_us;  // from the burst's zero
  double tolerance_us;
  enum edge_line line;
  uint8_t value;
  uint8_t step;
};

struct timeline {
  size_t count;
  struct edge edges[TIMELINE_MAX_EDGES];
};

const char* timeline_line_name(enum edge_line line);

void timeline_build(const struct rig* rig, const struct burst_plan* plan,
                    struct timeline* timeline);

#endif
