// rho_dt of eq. 3 and 5: the share of light that the rough surface lets through.
#pragma once

#include <algorithm>
#include <array>

#include "model/lobe.h"

namespace lamella::model {

// 1 minus the integral of the specular lobe over the hemisphere, against n.w: what enters from (or,
// by reciprocity, leaves towards) a direction w.
class TransmittanceTable {
 public:
  // A smooth clean interface: 1 - Fresnel.
  TransmittanceTable();
  // The lobe with specular intensity `c` (0.25 for a clean interface).
  TransmittanceTable(const LobeTable& lobe, double c);

  // `n_w` in (0, 1].
  float operator()(float n_w) const {
    const float x = std::clamp(n_w, 0.f, 1.f) * float(kCells);
    const int i = std::min(int(x), kCells - 1);
    const float below = cells_[size_t(i)], above = cells_[size_t(i) + 1];
    return below + (x - float(i)) * (above - below);
  }

 private:
  static constexpr int kCells = 64;
  std::array<float, kCells + 1> cells_{};
};

// Reflectance of the lobe with c = 1 for light from (towards) a direction at cosine `n_w`.
double directional_reflectance(const LobeTable& lobe, double n_w);

}  // namespace lamella::model
