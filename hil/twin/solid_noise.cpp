#include "twin/solid_noise.h"

#include <cmath>

namespace lamella::twin {

namespace {

uint32_t hash(int x, int y, int z, uint32_t seed) {
  uint32_t h = seed * 0x9e3779b1u + uint32_t(x) * 0x85ebca6bu + uint32_t(y) * 0xc2b2ae35u +
               uint32_t(z) * 0x27d4eb2fu;
  h ^= h >> 15, h *= 0x2c1b3c6du, h ^= h >> 12, h *= 0x297a2d39u, h ^= h >> 15;
  return h;
}

float unit_number(uint32_t h) { return float(h >> 8) * 0x1p-24f; }

}  // namespace

NoiseSample solid_noise(const Vec3& p, uint32_t seed) {
  int cell[3];
  float weight[3][2], slope[3][2];
  for (int a = 0; a < 3; ++a) {
    const float floor = std::floor(p[a]), t = p[a] - floor;
    cell[a] = int(floor);
    weight[a][1] = t * t * t * (t * (t * 6.f - 15.f) + 10.f);
    weight[a][0] = 1.f - weight[a][1];
    slope[a][1] = 30.f * t * t * (t * (t - 2.f) + 1.f);
    slope[a][0] = -slope[a][1];
  }
  NoiseSample sum;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = (corner >> 1) & 1, k = corner >> 2;
    const float v = 2.f * unit_number(hash(cell[0] + i, cell[1] + j, cell[2] + k, seed)) - 1.f;
    const float wx = weight[0][i], wy = weight[1][j], wz = weight[2][k];
    sum.value += v * wx * wy * wz;
    sum.gradient += Vec3(slope[0][i] * wy * wz, wx * slope[1][j] * wz, wx * wy * slope[2][k]) * v;
  }
  return sum;
}

float fractal_noise(const Vec3& p, int octaves, uint32_t seed) {
  float sum = 0, amplitude = 1, frequency = 1;
  for (int i = 0; i < octaves; ++i) {
    sum += amplitude * solid_noise(p * frequency, seed + uint32_t(i)).value;
    amplitude *= 0.5f;
    frequency *= 2.03f;
  }
  return sum;
}

Spot nearest_spot(const Vec3& p, uint32_t seed) {
  const Vec3 base(std::floor(p[0]), std::floor(p[1]), std::floor(p[2]));
  Spot best;
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      for (int k = -1; k <= 1; ++k) {
        const Vec3 cell = base + Vec3(float(i), float(j), float(k));
        const uint32_t h = hash(int(cell[0]), int(cell[1]), int(cell[2]), seed);
        const Vec3 at(unit_number(h), unit_number(h * 0x9e3779b1u), unit_number(h * 0x85ebca6bu));
        const float d = length(cell + at - p);
        if (d < best.distance) best = {d, unit_number(h * 0xc2b2ae35u)};
      }
    }
  }
  return best;
}

}  // namespace lamella::twin
