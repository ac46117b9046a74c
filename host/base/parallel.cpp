#include "base/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

namespace lamella {

// Each has a context of its own: where the other half of parallel_both throws, this half's loops
// still run to their ends, and what follows them finds what they were to make. A thread that waits
// for the end of its loop takes on no other work meanwhile: that might be the whole of the other
// half.
void parallel_for(int n, const std::function<void(int)>& body, int grain) {
  tbb::task_group_context own(tbb::task_group_context::isolated);
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(
        tbb::blocked_range<int>(0, n, size_t(grain)),
        [&](const tbb::blocked_range<int>& r) {
          for (int i = r.begin(); i != r.end(); ++i) body(i);
        },
        own);
  });
}

void parallel_both(const std::function<void()>& one, const std::function<void()>& other) {
  tbb::task_group_context own(tbb::task_group_context::isolated);
  tbb::parallel_invoke(one, other, own);
}

}  // namespace lamella
