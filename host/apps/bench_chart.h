// The bench as one page (SVG): a panel a knob, seconds against error, both relative to the
// default's; one of peers, and one of the default's error against its confidence.
#pragma once

#include "apps/bench_floor.h"
#include "apps/bench_run.h"

namespace lamella::apps {

// `title`: what was fitted. `knobs`: those of the bench, in its order. `floors`: those that were
// asked for.
std::string bench_chart(const Bench& bench, const std::vector<Knob>& knobs,
                        const std::vector<Floor>& floors, const std::string& title);

}  // namespace lamella::apps
