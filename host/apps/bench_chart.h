// The bench as one page (SVG): a panel a knob, seconds against error, both relative to the
// default's; and one of peers.
#pragma once

#include "apps/bench_run.h"

namespace lamella::apps {

// `title`: what was fitted. `knobs`: those of the bench, in its order.
std::string bench_chart(const Bench& bench, const std::vector<Knob>& knobs,
                        const std::string& title);

}  // namespace lamella::apps
