// What photographs say about a region's scattering kernel, compressed: normal equations in the
// weights of the Gaussian basis. Every photograph of a pattern is linear in them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "fit/gaussian_basis.h"

namespace lamella::fit {

// Minimises sum of weight (row . w - value)^2, the last of `row` being a constant offset.
struct KernelEquations {
  static constexpr int kUnknowns = GaussianBasis::kSize + 1;
  using Row = Eigen::Matrix<float, kUnknowns, 1>;
  using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;
  using Vector = Eigen::Matrix<double, kUnknowns, 1>;

  Matrix left = Matrix::Zero();
  Vector right = Vector::Zero();
  double square = 0;  // sum of weight value^2
  double count = 0;

  void add(const Vector& row, double value, double weight, double samples = 1);
  KernelEquations& operator+=(const KernelEquations& other);
  KernelEquations scaled(double factor) const;

  // sum of weight x squared residual at `unknowns`.
  double cost(const Vector& unknowns) const;
};

KernelEquations sum_of(const std::vector<const KernelEquations*>& equations);

// The same in the weights alone: whatever these are, the offset's best value within its sigma is
// linear in them. Minimises w'Aw - 2b'w.
struct WeightEquations {
  using Matrix = Eigen::Matrix<double, GaussianBasis::kSize, GaussianBasis::kSize>;
  using Vector = Eigen::Matrix<double, GaussianBasis::kSize, 1>;

  WeightEquations(const KernelEquations& equations, double offset_sigma);
  double offset(const Vector& weights) const;  // its best value at these
  double weight() const { return weight_; }    // sum over the samples

  Matrix a;
  Vector b;

 private:
  double weight_, stiffness_, right_;
  Vector coupling_;
};

struct Kernel {
  std::array<double, GaussianBasis::kSize> weight{};  // not negative, sum 1
  double offset = 0;
  double cost = 0;
};

// exp(-r/l)/(2 pi l r), the simplest kernel that is near to skin's at all distances, as weights.
GaussianBasis::Weights exponential_kernel(double l_mm);

// The kernel that explains the equations best: weights not negative and summing to 1 (what is
// measured is a ratio to the evenly lit photograph), the offset within `offset_sigma`. What the
// equations leave open is as in the exponential kernel that explains them best; `ridge` is how
// strongly it pulls.
Kernel solve_kernel(const KernelEquations& equations, double offset_sigma, double ridge);

// What equations count as, however many they are: neighbours' errors are alike.
inline constexpr double kCountedSamples = 100;

// Of dots: of the black level, relative to FRONT - BLACK.
inline constexpr double kOffsetSigma = 0.003;

}  // namespace lamella::fit
