#include "fit/gaussian_basis.h"

#include <cmath>

namespace lamella::fit {

double GaussianBasis::sigma_mm(int j) {
  return kNarrowest_mm * std::pow(kWidest_mm / kNarrowest_mm, j / (kSize - 1.0));
}

double GaussianBasis::value(int j, double r_mm) {
  const double s2 = sigma_mm(j) * sigma_mm(j) - kFootprint_mm * kFootprint_mm;
  return std::exp(-r_mm * r_mm / (2 * s2)) / (2 * M_PI * s2);
}

double GaussianBasis::profile(const Weights& weights, double r_mm) {
  double sum = 0;
  for (int j = 0; j < kSize; ++j) sum += weights[size_t(j)] * value(j, r_mm);
  return sum;
}

double GaussianBasis::transfer(int j, double cycles_per_mm) {
  const double x = M_PI * sigma_mm(j) * cycles_per_mm;
  return std::exp(-2 * x * x);
}

}  // namespace lamella::fit
