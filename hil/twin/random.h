// A small, fast, seedable generator (xoshiro128+): the same seed gives the same photographs.
#pragma once

#include <cmath>
#include <cstdint>

namespace lamella::twin {

// Spreads any number over 64 bits (SplitMix64).
inline uint64_t mix_bits(uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

class Random {
 public:
  explicit Random(uint64_t seed) {
    const uint64_t a = mix_bits(seed), b = mix_bits(a);
    s_[0] = uint32_t(a), s_[1] = uint32_t(a >> 32), s_[2] = uint32_t(b), s_[3] = uint32_t(b >> 32);
  }

  uint32_t next() {
    const uint32_t result = s_[0] + s_[3], t = s_[1] << 9;
    s_[2] ^= s_[0], s_[3] ^= s_[1], s_[1] ^= s_[2], s_[0] ^= s_[3], s_[2] ^= t;
    s_[3] = (s_[3] << 11) | (s_[3] >> 21);
    return result;
  }

  // Uniform in (0, 1): never 0, so that its logarithm is finite.
  float uniform() { return (float(next() >> 8) + 0.5f) * 0x1p-24f; }

  // Standard normal, Box-Muller, one of the pair.
  float normal() {
    const float r = std::sqrt(-2.f * std::log(uniform()));
    return r * std::cos(6.28318531f * uniform());
  }

 private:
  uint32_t s_[4];
};

}  // namespace lamella::twin
