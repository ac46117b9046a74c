// A scattering profile R(r) tabulated over r in units of its own length, integral over the plane 1.
#pragma once

#include <functional>
#include <vector>

namespace lamella::render {

class RadialKernel {
 public:
  // `profile`: R at r (any scale of R), r in units of the kernel's length; tabulated to `reach`
  // and cut there. Negative values, which a multipole has beyond what diffusion describes, are no
  // light: 0. Valid only where the integral is positive.
  RadialKernel(const std::function<double(double)>& profile, double reach);

  // Per unit area at distance `r_mm` for a kernel of length 1 / `per_mm`.
  float operator()(float r_mm, float per_mm) const {
    const float x = r_mm * per_mm * cells_per_length_;
    if (!(x < float(kCells))) return 0;
    const int i = int(x);
    const float t = x - float(i);
    return (table_[i] + t * (table_[i + 1] - table_[i])) * per_mm * per_mm;
  }

  float reach() const { return reach_; }
  bool valid() const { return valid_; }

 private:
  static constexpr int kCells = 1024;

  std::vector<float> table_;
  float cells_per_length_;
  float reach_;
  bool valid_;
};

}  // namespace lamella::render
