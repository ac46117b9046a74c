#include "fit/kernel_equations.h"

#include <algorithm>

namespace lamella::fit {

namespace {

constexpr int kSweeps = 3000;
constexpr double kSumWeight = 30;  // how much stiffer than the data the sum of 1 is

}  // namespace

void KernelEquations::add(const Vector& row, double value, double weight, double samples) {
  left.noalias() += weight * row * row.transpose();
  right += (weight * value) * row;
  square += weight * value * value;
  count += samples;
}

KernelEquations& KernelEquations::operator+=(const KernelEquations& other) {
  left += other.left;
  right += other.right;
  square += other.square;
  count += other.count;
  return *this;
}

KernelEquations KernelEquations::scaled(double factor) const {
  return {left * factor, right * factor, square * factor, count * factor};
}

double KernelEquations::cost(const Vector& unknowns) const {
  return unknowns.dot(left * unknowns) - 2 * right.dot(unknowns) + square;
}

Kernel solve_kernel(const KernelEquations& equations, double offset_sigma) {
  constexpr int n = GaussianBasis::kSize;
  KernelEquations::Matrix h = equations.left;
  KernelEquations::Vector g = equations.right;
  const double stiff = kSumWeight * h.topLeftCorner(n, n).trace() / n;
  h.topLeftCorner(n, n).array() += stiff;
  g.head(n).array() += stiff;
  h(n, n) += 1 / (offset_sigma * offset_sigma);
  // Coordinate descent: convex, and each step is exact within its bound.
  KernelEquations::Vector x = KernelEquations::Vector::Constant(1.0 / n);
  x(n) = 0;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (int j = 0; j <= n; ++j) {
      if (h(j, j) <= 0) continue;
      const double step = (g(j) - h.row(j).dot(x)) / h(j, j);
      x(j) = j < n ? std::max(0.0, x(j) + step) : x(j) + step;
    }
  }
  Kernel kernel;
  const double sum = x.head(n).sum();
  for (int j = 0; j < n; ++j) kernel.weight[size_t(j)] = x(j) / sum;
  kernel.offset = x(n);
  kernel.cost = equations.cost(x);
  return kernel;
}

}  // namespace lamella::fit
