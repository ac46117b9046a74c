// Run lengths come back as they went in, and damaged ones are refused.
#include "io/exr_runs.h"

#include <gtest/gtest.h>

namespace lamella {
namespace {

using Bytes = std::vector<uint8_t>;

Bytes repeated(size_t count, uint8_t byte) { return Bytes(count, byte); }

Bytes counting(size_t count) {
  Bytes bytes;
  for (size_t i = 0; i < count; ++i) bytes.push_back(uint8_t(i));
  return bytes;
}

Bytes joined(const std::vector<Bytes>& parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

TEST(ExrRuns, ComeBackAsTheyWentIn) {
  for (const Bytes& bytes :
       {Bytes{}, Bytes{7}, Bytes{7, 7}, repeated(3, 9), repeated(128, 9), repeated(129, 9),
        repeated(1000, 0), counting(127), counting(128), counting(1000),
        joined({counting(130), repeated(2, 5), counting(3), repeated(300, 1), counting(1)})}) {
    const Bytes packed = packed_runs(bytes);
    Bytes back(bytes.size());
    EXPECT_TRUE(unpack_runs(packed.data(), packed.size(), &back)) << bytes.size();
    EXPECT_EQ(back, bytes);
  }
}

TEST(ExrRuns, OfOneByteTakeTwoBytesForEvery128) {
  EXPECT_EQ(packed_runs(repeated(1280, 4)).size(), 20u);
}

TEST(ExrRuns, ThatAreCutOrOfAnotherSizeAreRefused) {
  const Bytes bytes = joined({counting(130), repeated(300, 1)});
  const Bytes packed = packed_runs(bytes);
  for (const size_t size : {bytes.size() - 1, bytes.size() + 1, size_t(0)}) {
    Bytes back(size);
    EXPECT_FALSE(unpack_runs(packed.data(), packed.size(), &back)) << size;
  }
  for (size_t left = 0; left < packed.size(); ++left) {
    const Bytes cut(packed.begin(), packed.begin() + ptrdiff_t(left));
    Bytes back(bytes.size());
    EXPECT_FALSE(unpack_runs(cut.data(), cut.size(), &back)) << left;
  }
}

}  // namespace
}  // namespace lamella
