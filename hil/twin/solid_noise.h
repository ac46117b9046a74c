// Smooth random fields in space, for skin that is not the same everywhere.
#pragma once

#include <cstdint>

#include "base/vec.h"

namespace lamella::twin {

struct NoiseSample {
  float value = 0;  // mean 0, about -1 to 1
  Vec3 gradient{0, 0, 0};
};

// Gradient-continuous value noise with one random number per unit cell.
NoiseSample solid_noise(const Vec3& p, uint32_t seed);

// Sum of `octaves` noises, each at twice the frequency and half the amplitude of the one before.
float fractal_noise(const Vec3& p, int octaves, uint32_t seed);

// Distance from `p` to the nearest of one random point per unit cell, and a number of that point
// in [0, 1): spots.
struct Spot {
  float distance = 1e9f, number = 0;
};
Spot nearest_spot(const Vec3& p, uint32_t seed);

}  // namespace lamella::twin
