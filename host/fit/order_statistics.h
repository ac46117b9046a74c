// The middle of some numbers, and the bright end of a picture.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "base/vec.h"

namespace lamella::fit {

// NaN of none. Reorders them.
template <class Real>
Real median_of(std::vector<Real>* values) {
  if (values->empty()) return std::numeric_limits<Real>::quiet_NaN();
  const auto middle = values->begin() + std::ptrdiff_t(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

// What 2 % of the pixels are brighter than. `image` has some.
inline float bright_end(const Image1& image) {
  std::vector<float> sorted(image.begin(), image.end());
  const auto bright = sorted.begin() + std::ptrdiff_t(0.98 * double(sorted.size() - 1));
  std::nth_element(sorted.begin(), bright, sorted.end());
  return *bright;
}

}  // namespace lamella::fit
