#include "base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace lamella {
namespace {

TEST(ParallelBoth, RunsBothWithLoopsInThem) {
  std::vector<int> one(1000, 0), other(1000, 0);
  parallel_both([&] { parallel_for(1000, [&](int i) { one[size_t(i)] += i; }); },
                [&] { parallel_for(1000, [&](int i) { other[size_t(i)] += 2 * i; }); });
  for (int i = 0; i < 1000; ++i) {
    ASSERT_EQ(one[size_t(i)], i);
    ASSERT_EQ(other[size_t(i)], 2 * i);
  }
}

TEST(ParallelBoth, ThrowsWhatOneOfThemThrew) {
  EXPECT_THROW(parallel_both([] { throw std::runtime_error("one"); }, [] {}), std::runtime_error);
  EXPECT_THROW(parallel_both([] {}, [] { throw std::runtime_error("other"); }), std::runtime_error);
}

// Failure: loops that end early and say nothing, once something beside them has thrown.
TEST(ParallelBoth, LetsTheLoopsOfOneRunToTheirEndsWhereTheOtherThrows) {
  for (int round = 0; round < 50; ++round) {
    std::vector<int> done(2000, 0);
    EXPECT_THROW(parallel_both([&] { parallel_for(2000, [&](int i) { done[size_t(i)] = 1; }); },
                               [] { throw std::runtime_error("other"); }),
                 std::runtime_error);
    const auto count = std::count(done.begin(), done.end(), 1);
    ASSERT_TRUE(count == 0 || count == 2000) << count;  // not begun, or whole
  }
}

}  // namespace
}  // namespace lamella
