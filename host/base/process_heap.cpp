#include "base/process_heap.h"

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "base/parallel.h"

namespace lamella {

namespace {

constexpr int kStep_bytes = 64 << 20, kNever_bytes = 0x7fffffff;
constexpr size_t kSlice_bytes = size_t(16) << 20;

bool is_kept = false;

}  // namespace

void keep_heap() {
#if defined(__GLIBC__)
  mallopt(M_ARENA_MAX, 1);
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TOP_PAD, kStep_bytes);
  mallopt(M_TRIM_THRESHOLD, kNever_bytes);
  is_kept = true;
#endif
}

void warm_heap(size_t bytes) {
#if defined(MADV_POPULATE_WRITE)
  if (!is_kept) return;
  bytes = std::min(bytes, size_t(kNever_bytes) / 8 * 7);  // what is larger would be given back
  void* const heap = std::malloc(bytes);
  if (!heap) return;
  const auto page = size_t(sysconf(_SC_PAGESIZE)), at = reinterpret_cast<uintptr_t>(heap);
  const uintptr_t first = (at + page - 1) / page * page;
  parallel_for(int((at + bytes - first) / kSlice_bytes), [&](int i) {
    void* const slice = reinterpret_cast<void*>(first + size_t(i) * kSlice_bytes);
    (void)madvise(slice, kSlice_bytes, MADV_POPULATE_WRITE);
  });
  std::free(heap);
#endif
}

}  // namespace lamella
