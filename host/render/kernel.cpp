#include "render/kernel.h"

#include <algorithm>
#include <cmath>

namespace lamella::render {

RadialKernel::RadialKernel(const std::function<double(double)>& profile, double reach)
    : table_(kCells + 2), cells_per_length_(float(kCells / reach)), reach_(float(reach)) {
  const double step = reach / kCells;
  double integral = 0;
  std::vector<double> values(table_.size());
  for (int i = 0; i < kCells + 2; ++i) values[i] = std::max(0., profile(i * step));
  for (int i = 0; i < kCells; ++i) {
    // 2 pi r R(r) with R linear between the two ends, as it is looked up.
    const double a = i * step, b = a + step;
    integral += M_PI / 3 * step * (values[i] * (2 * a + b) + values[i + 1] * (a + 2 * b));
  }
  valid_ = std::isfinite(integral) && integral > 0;
  for (int i = 0; i < kCells + 2; ++i) table_[i] = valid_ ? float(values[i] / integral) : 0;
}

}  // namespace lamella::render
