// Loops over all cores (oneTBB). Bodies must not throw and must write disjoint data.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace lamella {

// body(i) for i in [0, n), in chunks of `grain`.
template <class Body>
void parallel_for(int n, const Body& body, int grain = 1) {
  tbb::parallel_for(tbb::blocked_range<int>(0, n, grain), [&](const tbb::blocked_range<int>& r) {
    for (int i = r.begin(); i != r.end(); ++i) body(i);
  });
}

}  // namespace lamella
