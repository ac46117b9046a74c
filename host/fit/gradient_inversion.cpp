#include "fit/gradient_inversion.h"

namespace lamella::fit {

namespace {

constexpr int kMostRounds = 8;
constexpr float kSettledRad = 1e-3f;

Lanes splat(float value) { return Lanes{} + value; }

void normalise(LaneVec3* v) {
  const Lanes square = (*v)[0] * (*v)[0] + (*v)[1] * (*v)[1] + (*v)[2] * (*v)[2];
  Lanes scale;
  for (int k = 0; k < kLanes; ++k) scale[k] = 1.f / std::sqrt(std::max(square[k], 1e-20f));
  for (Lanes& component : *v) component *= scale;
}

}  // namespace

LedsFrom::LedsFrom(const LightStage& stage, const Vec3& x_mm) {
  const size_t count = stage.leds().size();
  towards.reserve(count);
  axis.reserve(count);
  irradiance.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    towards.push_back(stage.direction_from(i, x_mm));
    axis.push_back(stage.leds()[i].direction);
    irradiance.push_back(stage.irradiance(i, x_mm));
  }
}

LaneVec3 lambertian_mean_direction(const LedsFrom& leds, int channel, const LaneVec3& normal) {
  LaneVec3 sum{};
  Lanes full = splat(1e-12f);
  for (size_t i = 0; i < leds.towards.size(); ++i) {
    const Vec3& l = leds.towards[i];
    const Lanes cosine = normal[0] * l[0] + normal[1] * l[1] + normal[2] * l[2];
    const Lanes gives = (cosine > 0.f ? cosine : splat(0.f)) * leds.irradiance[i][channel];
    full += gives;
    for (int a = 0; a < 3; ++a) sum[size_t(a)] += gives * leds.axis[i][a];
  }
  for (Lanes& component : sum) component /= full;
  return sum;
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
      n.normal[a] += 1.5f * d;
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
  const LaneVec3 m = lambertian_mean_direction(
      leds, channel, LaneVec3{splat(normal[0]), splat(normal[1]), splat(normal[2])});
  return {m[0][0], m[1][0], m[2][0]};
}

Vec3 invert_mean_direction(const LedsFrom& leds, int channel, const Vec3& mean_direction,
                           const Vec3& guess) {
  const auto lanes = [](const Vec3& v) { return LaneVec3{splat(v[0]), splat(v[1]), splat(v[2])}; };
  const LaneVec3 n =
      invert_mean_direction(leds, channel, lanes(mean_direction), lanes(guess)).normal;
  return {n[0][0], n[1][0], n[2][0]};
}

}  // namespace lamella::fit
