// From gradients to normals by inverting the sum over the LEDs that are really there.
//
// With C the photograph under all LEDs and G_a under the gradient of axis a, level (1 + w.a)/2,
// m_a = (2 G_a - C)/C is the mean direction of the LEDs weighted by what each gives to the
// photograph, whatever the material: 2 level - 1 = w.a. For a Lambertian surface each LED gives
// E_i max(0, n.l_i).
#pragma once

#include <array>
#include <vector>

#include "base/light_stage.h"

namespace lamella::fit {

// Eight pixels side by side.
inline constexpr int kLanes = 8;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
using LaneVec3 = std::array<Lanes, 3>;

// The LEDs as a point sees them, number by number, padded with dark ones to whole `Lanes`.
class LedsFrom {
 public:
  LedsFrom(const LightStage& stage, const Vec3& x_mm);

  size_t count() const { return count_; }
  Vec3 towards(size_t led) const { return three(kTowards, led); }  // l_i, unit
  Vec3 axis(size_t led) const { return three(kAxis, led); }        // w_i, which sets the level
  Vec3 irradiance(size_t led) const { return three(kIrradiance, led); }  // rgb

  enum Number { kTowards = 0, kAxis = 3, kIrradiance = 6, kNumbers = 9 };

  // Of every LED: component or channel `k`.
  const float* all(Number number, int k) const {
    return numbers_.data() + size_t(number + k) * padded_;
  }
  size_t padded() const { return padded_; }

 private:
  Vec3 three(Number n, size_t led) const {
    return {all(n, 0)[led], all(n, 1)[led], all(n, 2)[led]};
  }

  size_t count_, padded_;
  std::vector<float> numbers_;
};

// m of a Lambertian surface with normal `n` that nothing shadows.
LaneVec3 lambertian_mean_direction(const LedsFrom& leds, int channel, const LaneVec3& normal);

struct LaneNormals {
  LaneVec3 normal{};  // unit
  Lanes mismatch{};   // how far m(n) stays from m: there are three numbers in m, two in n
};

// The normals whose Lambertian m is `mean_direction`, starting from `guess`. On a full, even sphere
// m = 2/3 n, so that n + 3/2 (m - m(n)) is a Newton step but for the gaps between LEDs.
LaneNormals invert_mean_direction(const LedsFrom& leds, int channel, const LaneVec3& mean_direction,
                                  const LaneVec3& guess);

// Not normalised: where the normals go whose mean direction is `wanted` instead of `is`.
LaneVec3 newton_step(const LaneVec3& normal, const LaneVec3& wanted, const LaneVec3& is);

// m and its inversion for one normal, eight LEDs at a time.
Vec3 lambertian_mean_direction(const LedsFrom& leds, int channel, const Vec3& normal);
Vec3 invert_mean_direction(const LedsFrom& leds, int channel, const Vec3& mean_direction,
                           const Vec3& guess);

}  // namespace lamella::fit
