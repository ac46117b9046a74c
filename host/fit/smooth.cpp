#include "fit/smooth.h"

namespace lamella::fit {

std::vector<float> gaussian_taps(float sigma_px) {
  std::vector<float> taps;
  const int reach = int(std::ceil(2 * sigma_px));
  for (int k = 0; k <= reach; ++k) {
    taps.push_back(std::exp(-0.5f * float(k * k) / (sigma_px * sigma_px)));
  }
  return taps;
}

}  // namespace lamella::fit
