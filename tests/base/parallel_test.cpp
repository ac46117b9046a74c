#include "base/parallel.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace lamella
