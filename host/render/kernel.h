// A scattering profile R(r) tabulated over r in units of its own length, integral over the plane 1.
#pragma once

#include <functional>
#include <vector>

namespace lamella::render {

class RadialKernel {
 public:
  // `profile`: R at r (any scale of R), r in units of the kernel's length; tabulated to `reach`
  // and cut there. Valid only where the integral is positive.
  RadialKernel(const std::function<double(double)>& profile, double reach);

  // Per unit area at distance `r` for a kernel of length `scale`, both mm.
  float operator()(float r_mm, float scale_mm) const {
    const float inverse = 1 / scale_mm;
    const float x = r_mm * inverse * cells_per_length_;
    const int i = int(x);
    if (i + 1 >= int(table_.size())) return 0;
    const float t = x - float(i);
    return (table_[i] + t * (table_[i + 1] - table_[i])) * inverse * inverse;
  }

  float reach() const { return reach_; }
  bool valid() const { return valid_; }

 private:
  std::vector<float> table_;
  float cells_per_length_;
  float reach_;
  bool valid_;
};

}  // namespace lamella::render
