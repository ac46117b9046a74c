// Values of a map between its pixels.
#pragma once

#include <algorithm>

#include "base/vec.h"

namespace lamella::render {

// Bilinear at `pixel` (x, y), over those of the four neighbours that are known; NaN where none is.
template <class Value>
Value look_up(const cv::Mat_<Value>& map, const cv::Vec2f& pixel) {
  const int x0 = std::clamp(int(pixel[0]), 0, map.cols - 2);
  const int y0 = std::clamp(int(pixel[1]), 0, map.rows - 2);
  const float fx = pixel[0] - float(x0), fy = pixel[1] - float(y0);
  Value sum{};
  float total = 0;
  for (int k = 0; k < 4; ++k) {
    const float w = (k & 1 ? fx : 1 - fx) * (k & 2 ? fy : 1 - fy);
    const Value& value = map(y0 + (k >> 1), x0 + (k & 1));
    if (w <= 0 || !is_finite(value)) continue;
    sum += value * w;
    total += w;
  }
  return sum * (total > 0 ? 1 / total : kNaN);
}

}  // namespace lamella::render
