// While edges are played nothing is allocated and no page is missing.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstdlib>

#include "session_bench.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SANITIZED 1
#endif
#endif

#ifndef SANITIZED

namespace {

thread_local int allocations = 0;

long page_faults() {
  rusage usage;
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_minflt + usage.ru_majflt;
}

}  // namespace

// Every allocation of this program comes through here, the firmware's among them.
extern "C" {
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* block, size_t size);

void* malloc(size_t size) {
  allocations++;
  return __libc_malloc(size);
}
void* calloc(size_t count, size_t size) {
  allocations++;
  return __libc_calloc(count, size);
}
void* realloc(void* block, size_t size) {
  allocations++;
  return __libc_realloc(block, size);
}
}

TEST(TimeCritical, AnAllocationWouldBeSeen) {
  const int before = allocations;
  void* volatile block = malloc(10);
  free(block);
  EXPECT_EQ(allocations, before + 1);
}

TEST(TimeCritical, EdgesArePlayedWithoutAllocationAndWithoutPageFaults) {
  Bench bench;
  bench.burst();  // pages in the program, as locking memory does on a board
  ASSERT_EQ(session_request_burst(&bench.session, true), LAM_OK);
  session_work(&bench.session);
  ASSERT_TRUE(bench.session.playing);
  const long faults = page_faults();
  const int before = allocations;
  while (bench.session.playing) {
    session_watch(&bench.session);
    session_work(&bench.session);
  }
  const int after = allocations;
  EXPECT_EQ(page_faults() - faults, 0);
  EXPECT_EQ(after - before, 0);
  EXPECT_EQ(bench.session.state, lamella_v1_RigState_RUNNING);
}

#endif
