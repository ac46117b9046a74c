#include "apps/process_heap.h"

#include <malloc.h>

namespace lamella::apps {

void keep_heap() {
#if defined(__GLIBC__)
  constexpr int kStep_bytes = 64 << 20, kNever_bytes = 0x7fffffff;
  mallopt(M_ARENA_MAX, 1);
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TOP_PAD, kStep_bytes);
  mallopt(M_TRIM_THRESHOLD, kNever_bytes);
#endif
}

}  // namespace lamella::apps
