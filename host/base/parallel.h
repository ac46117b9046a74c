// Loops over all cores (oneTBB). Bodies must write disjoint data.
#pragma once

#include <functional>

namespace lamella {

// body(i) for i in [0, n), in chunks of `grain`; throws what one of them threw. The body is
// compiled once and called through a pointer: inlined into oneTBB it would be several copies, whose
// contracted multiplications and additions differ in the last bit, and which of them an i met would
// depend on who stole from whom.
void parallel_for(int n, const std::function<void(int)>& body, int grain = 1);

// Runs both at the same time; throws what one of them threw. Loops inside them share the cores.
void parallel_both(const std::function<void()>& one, const std::function<void()>& other);

}  // namespace lamella
