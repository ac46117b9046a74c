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

namespace {

// Both sides of the middle.
float sum_of(const std::vector<float>& taps) {
  float sum = -taps[0];
  for (float t : taps) sum += 2 * t;
  return sum;
}

// Of two averages' weights.
float product(const std::vector<float>& a, const std::vector<float>& b) {
  float sum = -a[0] * b[0];
  for (size_t k = 0; k < std::min(a.size(), b.size()); ++k) sum += 2 * a[k] * b[k];
  return sum / (sum_of(a) * sum_of(b));
}

}  // namespace

float noise_gain(const std::vector<float>& taps) {
  const float one = product(taps, taps);
  return one * one;
}

float noise_gain(const std::vector<float>& fine, const std::vector<float>& coarse) {
  const float both = product(fine, coarse);
  return noise_gain(fine) - 2 * both * both + noise_gain(coarse);
}

}  // namespace lamella::fit
