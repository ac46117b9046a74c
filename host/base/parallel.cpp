#include "base/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

namespace lamella {

// A thread that waits for the end of its loop takes on no other work meanwhile: that might be the
// whole of the other half of parallel_both.
void parallel_for(int n, const std::function<void(int)>& body, int grain) {
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(tbb::blocked_range<int>(0, n, size_t(grain)),
                      [&](const tbb::blocked_range<int>& r) {
                        for (int i = r.begin(); i != r.end(); ++i) body(i);
                      });
  });
}

void parallel_both(const std::function<void()>& one, const std::function<void()>& other) {
  tbb::parallel_invoke(one, other);
}

}  // namespace lamella
