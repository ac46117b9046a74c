// The distribution p(h) of eq. 1: how often the surface's facets face a direction h, per steradian,
// normalised so that the integral of p cos(theta) over the hemisphere is 1.
#pragma once

#include <algorithm>
#include <vector>

#include "base/vec.h"

namespace lamella::model {

// A lobe as data: a table against theta from 0, with a tail beyond its end that keeps falling as a
// Gaussian in theta with the slope that the table ends with.
class LobeTable {
 public:
  LobeTable() = default;
  // `theta_rad` rising from 0, at least two; `p` not negative. The lobe is scaled to integrate to
  // 1, tail included.
  LobeTable(const std::vector<double>& theta_rad, const std::vector<double>& p);

  // p at an angle whose cosine is `cos_theta`, per steradian; its value at the horizon below it.
  float density(float cos_theta) const {
    // Without a branch, so that loops over lights become vector code.
    const float x = std::clamp((1.f - cos_theta) * float(kCells), 0.f, float(kCells));
    const int i = int(x);
    const float below = cells_[size_t(i)], above = cells_[size_t(i) + 1];
    return below + (x - float(i)) * (above - below);
  }

  // The same values as one looks them up: cells()[i] is p where 1 - cos(theta) = i / kCells.
  static constexpr int kCells = 2048;
  const std::vector<float>& cells() const { return cells_; }

 private:
  std::vector<float> cells_ = std::vector<float>(kCells + 2, 0.f);
};

// One facet distribution with Gaussian slopes (Beckmann): exp(-(tan(theta)/m)^2)/(pi m^2 cos^4),
// normalised as p is. Rises with theta beyond m = 0.7, where it is no lobe any more.
double beckmann(double cos_theta, double m);

// m of a exp(-(theta/m)^2), by least squares over the table.
double gaussian_width(const std::vector<double>& theta_rad, const std::vector<double>& p);

// Integral of p cos(theta) over the cone that the table covers (trapezoids in theta).
double integral_over_table(const std::vector<double>& theta_rad, const std::vector<double>& p);

}  // namespace lamella::model
