// A radial profile as a sum of two-dimensional Gaussians. Blurring, Fourier transforms and
// convolution with a pattern are then closed forms, and what is measured is linear in the weights.
#pragma once

#include <array>

namespace lamella::fit {

// The widths that all profiles share, geometric. Every Gaussian integrates to 1 over the plane.
struct GaussianBasis {
  static constexpr int kSize = 14;
  static constexpr double kNarrowest_mm = 0.1, kWidest_mm = 8.0;
  using Weights = std::array<double, kSize>;

  static double sigma_mm(int j);

  // Sum of weights x Gaussians at radius r, per mm^2.
  static double profile(const Weights& weights, double r_mm);

  // exp(-2 pi^2 sigma^2 f^2): share of a wave of f cycles per mm that Gaussian j lets through.
  static double transfer(int j, double cycles_per_mm);
};

}  // namespace lamella::fit
