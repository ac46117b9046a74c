// Timed edges as a VCD file, which every logic analyser's viewer opens (IEEE 1364, section 18).
#pragma once

#include <set>
#include <string>

#include "link.pb.h"

namespace lamella {

enum class EdgeTime { kPlanned, kActual };

// Nanoseconds, so that edges less than a microsecond apart stay apart. Lines hold their level;
// what only happens at a moment (SHIFT, COMMIT, VBLANK, ARRIVED) is a pulse of 10 us. BLANK is 1
// before its first edge, every other line 0. Edges may come in any order; times before 0 are 0.
// Lines that are active low are the other way round: what a probe on them sees.
std::string vcd_text(const google::protobuf::RepeatedPtrField<v1::TimedEdge>& edges, EdgeTime time,
                     const std::set<std::string>& active_low = {});

}  // namespace lamella
