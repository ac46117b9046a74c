#include "fit/gradient_inversion.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace lamella::fit {

namespace {

constexpr int kMostRounds = 8;
constexpr float kSettledRad = 4e-3f;
constexpr float kNewtonStep = 1.5f;

Lanes splat(float value) { return Lanes{} + value; }

Lanes load(const float* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof(lanes));
  return lanes;
}

float total(const Lanes& lanes) {
  float sum = 0;
  for (int k = 0; k < kLanes; ++k) sum += lanes[k];
  return sum;
}

// One vector of every LED.
struct LedNumbers {
  const float *x, *y, *z;
  LedNumbers(const LedsFrom& leds, LedsFrom::Number number)
      : x(leds.all(number, 0)), y(leds.all(number, 1)), z(leds.all(number, 2)) {}
};

void normalise(LaneVec3* v) {
  const Lanes square = (*v)[0] * (*v)[0] + (*v)[1] * (*v)[1] + (*v)[2] * (*v)[2];
  Lanes scale;
  for (int k = 0; k < kLanes; ++k) scale[k] = 1.f / std::sqrt(std::max(square[k], 1e-20f));
  for (Lanes& component : *v) component *= scale;
}

}  // namespace

LedsFrom::LedsFrom(const LightStage& stage, const Vec3& x_mm)
    : count_(stage.leds().size()),
      padded_((count_ + kLanes - 1) / kLanes * kLanes),
      numbers_(padded_ * kNumbers, 0.f) {
  const auto set = [&](Number number, size_t led, const Vec3& value) {
    for (size_t k = 0; k < 3; ++k) numbers_[(size_t(number) + k) * padded_ + led] = value[int(k)];
  };
  for (size_t i = 0; i < count_; ++i) {
    set(kTowards, i, stage.direction_from(i, x_mm));
    set(kAxis, i, stage.leds()[i].direction);
    set(kIrradiance, i, stage.irradiance(i, x_mm));
  }
}

LaneVec3 lambertian_mean_direction(const LedsFrom& leds, int channel, const LaneVec3& normal) {
  LaneVec3 sum{};
  Lanes full = splat(1e-12f);
  const float* const irradiance = leds.all(LedsFrom::kIrradiance, channel);
  const LedNumbers towards(leds, LedsFrom::kTowards), axis(leds, LedsFrom::kAxis);
  for (size_t i = 0; i < leds.count(); ++i) {
    const Lanes cosine =
        normal[0] * towards.x[i] + normal[1] * towards.y[i] + normal[2] * towards.z[i];
    const Lanes gives = (cosine > 0.f ? cosine : splat(0.f)) * irradiance[i];
    full += gives;
    sum[0] += gives * axis.x[i];
    sum[1] += gives * axis.y[i];
    sum[2] += gives * axis.z[i];
  }
  for (Lanes& component : sum) component /= full;
  return sum;
}

LaneVec3 newton_step(const LaneVec3& normal, const LaneVec3& wanted, const LaneVec3& is) {
  LaneVec3 moved = normal;
  for (size_t a = 0; a < 3; ++a) moved[a] += kNewtonStep * (wanted[a] - is[a]);
  return moved;
}

LaneNormals invert_mean_direction(const LedsFrom& leds, int channel, const LaneVec3& mean_direction,
                                  const LaneVec3& guess) {
  LaneNormals n{guess, {}};
  normalise(&n.normal);
  for (int round = 0; round < kMostRounds; ++round) {
    const LaneVec3 before = n.normal, predicted = lambertian_mean_direction(leds, channel, before);
    Lanes off{}, step{};
    for (size_t a = 0; a < 3; ++a) {
      const Lanes d = mean_direction[a] - predicted[a];
      off += d * d;
      n.normal[a] += kNewtonStep * d;
    }
    normalise(&n.normal);
    for (size_t a = 0; a < 3; ++a) step += (n.normal[a] - before[a]) * (n.normal[a] - before[a]);
    float longest = 0;
    for (int k = 0; k < kLanes; ++k) {
      n.mismatch[k] = std::sqrt(off[k]);
      longest = std::max(longest, step[k]);
    }
    if (longest < kSettledRad * kSettledRad) break;
  }
  return n;
}

Vec3 lambertian_mean_direction(const LedsFrom& leds, int channel, const Vec3& normal) {
  LaneVec3 sum{};
  Lanes full{};
  const float* const irradiance = leds.all(LedsFrom::kIrradiance, channel);
  const LedNumbers towards(leds, LedsFrom::kTowards), axis(leds, LedsFrom::kAxis);
  for (size_t i = 0; i < leds.padded(); i += kLanes) {
    const Lanes cosine = load(towards.x + i) * normal[0] + load(towards.y + i) * normal[1] +
                         load(towards.z + i) * normal[2];
    const Lanes gives = (cosine > 0.f ? cosine : splat(0.f)) * load(irradiance + i);
    full += gives;
    sum[0] += gives * load(axis.x + i);
    sum[1] += gives * load(axis.y + i);
    sum[2] += gives * load(axis.z + i);
  }
  return Vec3(total(sum[0]), total(sum[1]), total(sum[2])) * (1 / (1e-12f + total(full)));
}

Vec3 invert_mean_direction(const LedsFrom& leds, int channel, const Vec3& mean_direction,
                           const Vec3& guess) {
  Vec3 n = guess * (1 / std::sqrt(std::max(dot(guess, guess), 1e-20f)));
  for (int round = 0; round < kMostRounds; ++round) {
    const Vec3 before = n;
    n += kNewtonStep * (mean_direction - lambertian_mean_direction(leds, channel, n));
    n *= 1 / std::sqrt(std::max(dot(n, n), 1e-20f));
    if (!(dot(n - before, n - before) >= kSettledRad * kSettledRad)) break;
  }
  return n;
}

}  // namespace lamella::fit
