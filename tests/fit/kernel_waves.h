// What a camera sees of a kernel, wave by wave.
#pragma once

#include <cmath>

#include "fit/layer_profile.h"

namespace lamella::fit::testing {

// The share of a wave of f cycles per mm that a kernel lets through: its Hankel transform.
inline double wave_share(const RadialProfile& kernel, double f) {
  double sum = 0;
  for (double r = 5e-4; r < 40; r *= 1.002) {
    sum += kernel(r) * std::cyl_bessel_j(0.0, 2 * M_PI * f * r) * 2 * M_PI * r * r * 0.002;
  }
  return sum;
}

}  // namespace lamella::fit::testing
