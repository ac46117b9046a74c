// A radial profile as a sum of two-dimensional Gaussians. Blurring, Fourier transforms and
// convolution with a pattern are then closed forms, and what is measured is linear in the weights.
#pragma once

#include <array>
#include <functional>

namespace lamella::fit {

using RadialProfile = std::function<double(double r_mm)>;  // per mm^2

// The widths that all profiles share, geometric. Every Gaussian integrates to 1 over the plane.
struct GaussianBasis {
  static constexpr int kSize = 14;
  static constexpr double kNarrowest_mm = 0.12, kWidest_mm = 8.0;

  // What the pixels of camera and projector blur every photograph of a pattern by (one sigma of two
  // boxes of 0.25 to 0.3 mm). Widths include it; profiles do not.
  static constexpr double kFootprint_mm = 0.1;

  using Weights = std::array<double, kSize>;

  static double sigma_mm(int j);

  // The blur's share of Gaussian j removed, at radius r, per mm^2.
  static double value(int j, double r_mm);

  // Sum of weights x values.
  static double profile(const Weights& weights, double r_mm);

  // exp(-2 pi^2 sigma^2 f^2): share of a wave of f cycles per mm that Gaussian j lets through.
  static double transfer(int j, double cycles_per_mm);
};

}  // namespace lamella::fit
