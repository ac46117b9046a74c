// What no order of steps can beat: to know how good a plan is without trying every order.
#ifndef LAMELLA_FIRMWARE_BURST_BOUND_H
#define LAMELLA_FIRMWARE_BURST_BOUND_H

#include "burst.h"

struct burst_bound {
  double duration_us;
  double cost_us;
};

// Of all orders with one actuator move, mirrored or not.
//
// Duration: exact for that larger set. A step's times depend on its light, on its side of the move
// and on the clock alone, and a clock that is ahead stays ahead (burst_clock.h), so the least clock
// for every count of steps done is all that has to be kept.
//
// Separations: of m pairs, their sum is that of the openings on the far side of the move less that
// of the openings on the near side, whoever is paired with whom. Across the move lies at least the
// shortest exposure and the shortest gap; each pair but the innermost has, on either side, at least
// one more of the shortest exposure with its shortest wait for every pair inside it:
// m (exposure + gap) + m (m - 1) cycle.
//
// Cost: both at once, which need not be possible.
struct burst_bound burst_bound(const struct rig* rig, const struct burst_step steps[], size_t count,
                               bool starts_crossed);

#endif
