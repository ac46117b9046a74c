// What a burst tells of how far the LEDs are off their calibration: the mean direction of the light
// that skin shows under the gradients, against what its shape, triangulated, says it should be. The
// skin averages over the half of the sphere that it faces: an error of single LEDs is not in it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "base/light_stage.h"

namespace lamella::fit {

// One place of the subject.
struct LedWitness {
  Vec3 normal;    // unit, rig frame, by the shape alone
  Vec3 off;       // m measured, shadows and bounces removed, less m of `normal`
  int group = 0;  // 0 to kWitnessGroups - 1: places that err alike are of one
};

inline constexpr int kWitnessGroups = 12;

struct LedGains {
  static constexpr int kOrders = 8;  // x, y, z, xy, yz, zx, x^2 - y^2, 3 z^2 - 1 of w

  // Of all that a gradient frame X, Y, Z shows, over what GRADIENT_FULL does: less 1.
  std::array<double, 3> gradient{}, gradient_stddev{};
  // Relative error of the LED in direction w: sum of these times the functions above.
  std::array<double, kOrders> low_order{}, low_order_stddev{};
  bool is_known = false;   // there are witnesses enough
  bool is_mended = false;  // a gradient's gain is beyond three of its sigmas
  std::string why;         // nothing is known

  bool beyond(size_t axis) const;

  // What the frames of a gradient are divided by: 1 where its gain is within its sigmas.
  float mended_gain(size_t axis) const;
};

// Robust least squares on all witnesses; deviations by leaving out one group after the other, and
// by what is found where there is no error. Gradients and low orders are two readings of one
// difference, not to be added up.
LedGains estimate_led_gains(const LightStage& stage, const std::vector<LedWitness>& witnesses);

}  // namespace lamella::fit
