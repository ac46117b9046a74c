// How far phasors agree; and the angle of one, quicker than the mathematical library's: half of the
// time of reading fringes went there.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/vec.h"

namespace lamella::fit {

// Of the direction (cosine, sine), of any length, in turns from -1/2 to 1/2, to 3e-7; 0 where both
// are 0. The polynomial is Chebyshev's for atan(a) / (2 pi a) in a^2 on [0, 1].
inline float turns_of(float sine, float cosine) {
  const float x = std::abs(cosine), y = std::abs(sine);
  const float a = std::min(x, y) / std::max(std::max(x, y), 1e-30f), s = a * a;
  float turns = 0.0012454643f;
  for (float term :
       {-0.0058725993f, 0.013327883f, -0.021454731f, 0.031639799f, -0.053040572f, 0.15915483f}) {
    turns = turns * s + term;
  }
  turns *= a;
  turns = y > x ? 0.25f - turns : turns;
  turns = cosine < 0 ? 0.5f - turns : turns;
  return std::copysign(turns, sine);
}

// Length of the sum of phasors (cosine, sine) over the sum of their lengths, of every `step`th one
// each way: 1 where all point one way, 0 where they point anywhere; NaN where all are 0.
inline double coherence_of(const Image2& phasors, int step) {
  cv::Vec3d sum(0, 0, 0);
  for (int y = 0; y < phasors.rows; y += step) {
    for (int x = 0; x < phasors.cols; x += step) {
      const Vec2 phasor = phasors(y, x);
      sum += cv::Vec3d(phasor[0], phasor[1], std::hypot(phasor[0], phasor[1]));
    }
  }
  return sum[2] > 0 ? std::hypot(sum[0], sum[1]) / sum[2] : std::nan("");
}

}  // namespace lamella::fit
