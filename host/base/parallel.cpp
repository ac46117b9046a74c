#include "base/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace lamella {

void parallel_for(int n, const std::function<void(int)>& body, int grain) {
  tbb::parallel_for(tbb::blocked_range<int>(0, n, size_t(grain)),
                    [&](const tbb::blocked_range<int>& r) {
                      for (int i = r.begin(); i != r.end(); ++i) body(i);
                    });
}

}  // namespace lamella
