#include "fit/kernel_equations.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

namespace lamella::fit {

namespace {

constexpr int kSize = GaussianBasis::kSize;
constexpr double kSumWeight = 1000;   // how much stiffer than the data the sum of 1 is
constexpr double kRidgeFloor = 0.02;  // weights move by this against the pull of 1
constexpr int kLengths = 48;          // exponential kernels to choose from
constexpr double kShortest_mm = 0.15, kLongest_mm = 4;

using BasisMatrix = WeightEquations::Matrix;
using BasisVector = WeightEquations::Vector;
using Weights = GaussianBasis::Weights;

// Least x'ax - 2b'x over x not negative.
struct KernelProgram {
  BasisMatrix a;
  BasisVector b;
};

// Minimises x'Ax - 2b'x over the unknowns that are `free`; the others are 0.
BasisVector solve_free(const BasisMatrix& a, const BasisVector& b,
                       const std::array<bool, kSize>& free) {
  BasisMatrix m = a;
  BasisVector v = b;
  for (int j = 0; j < kSize; ++j) {
    if (free[size_t(j)]) continue;
    m.row(j).setZero();
    m.col(j).setZero();
    m(j, j) = 1;
    v(j) = 0;
  }
  return m.ldlt().solve(v);
}

// Frees the unknown with the steepest descent, solves, and puts those that turn negative back to 0
// (Lawson and Hanson 1974).
BasisVector solve_program(const KernelProgram& program) {
  const auto& [a, b] = program;
  BasisVector x = BasisVector::Zero();
  std::array<bool, kSize> free{};
  const double tolerance = 1e-10 * b.cwiseAbs().maxCoeff();
  for (int round = 0; round < 3 * kSize; ++round) {
    const BasisVector descent = b - a * x;
    int steepest = -1;
    for (int j = 0; j < kSize; ++j) {
      if (free[size_t(j)] || descent(j) <= tolerance) continue;
      if (steepest < 0 || descent(j) > descent(steepest)) steepest = j;
    }
    if (steepest < 0) break;
    free[size_t(steepest)] = true;
    for (int inner = 0; inner < kSize; ++inner) {
      const BasisVector to = solve_free(a, b, free);
      double step = 1;
      for (int j = 0; j < kSize; ++j) {
        if (free[size_t(j)] && to(j) <= 0) step = std::min(step, x(j) / (x(j) - to(j)));
      }
      x += step * (to - x);
      if (step >= 1) break;
      for (int j = 0; j < kSize; ++j) {
        if (free[size_t(j)] && x(j) <= 1e-15) x(j) = 0, free[size_t(j)] = false;
      }
    }
  }
  return x;
}

Eigen::Map<const BasisVector> as_vector(const Weights& weights) {
  return Eigen::Map<const BasisVector>(weights.data());
}

const std::vector<Weights>& exponential_kernels() {
  static const std::vector<Weights> kernels = [] {
    std::vector<Weights> all;
    for (int i = 0; i < kLengths; ++i) {
      const double t = i / (kLengths - 1.0);
      all.push_back(exponential_kernel(kShortest_mm * std::pow(kLongest_mm / kShortest_mm, t)));
    }
    return all;
  }();
  return kernels;
}

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

KernelEquations sum_of(const std::vector<const KernelEquations*>& equations) {
  KernelEquations sum;
  for (const KernelEquations* some : equations) sum += *some;
  return sum;
}

double KernelEquations::cost(const Vector& unknowns) const {
  return unknowns.dot(left * unknowns) - 2 * right.dot(unknowns) + square;
}

Weights exponential_kernel(double l_mm) {
  constexpr int kRings = 120;
  BasisMatrix a = BasisMatrix::Zero();
  BasisVector b = BasisVector::Zero();
  for (int i = 0; i < kRings; ++i) {
    const double r = 0.01 * std::pow(2000.0, i / (kRings - 1.0));
    const double y = std::exp(-r / l_mm) / (2 * M_PI * l_mm * r);
    const double weight = r * r / (r * r * y + 1e-5);
    BasisVector row;
    for (int j = 0; j < kSize; ++j) row(j) = GaussianBasis::value(j, r);
    a.noalias() += weight * row * row.transpose();
    b += weight * y * row;
  }
  const BasisVector x = solve_program({a, b});
  Weights weights;
  for (int j = 0; j < kSize; ++j) weights[size_t(j)] = x(j) / x.sum();
  return weights;
}

WeightEquations::WeightEquations(const KernelEquations& equations, double offset_sigma)
    : weight_(equations.left(kSize, kSize)),
      stiffness_(weight_ + 1 / (offset_sigma * offset_sigma)),
      right_(equations.right(kSize)),
      coupling_(equations.left.topRightCorner<kSize, 1>()) {
  a = equations.left.topLeftCorner<kSize, kSize>() - coupling_ * coupling_.transpose() / stiffness_;
  b = equations.right.head<kSize>() - coupling_ * right_ / stiffness_;
}

double WeightEquations::offset(const BasisVector& weights) const {
  return (right_ - coupling_.dot(weights)) / stiffness_;
}

namespace {

// The sum of 1 is one more equation that is much stiffer than the data.
KernelProgram kernel_program(const KernelEquations& equations, double offset_sigma, double ridge) {
  const WeightEquations reduced(equations, offset_sigma);
  const double scale = kCountedSamples / std::max(equations.count, 1.0);
  const BasisMatrix h = scale * reduced.a;
  const BasisVector g = scale * reduced.b;
  const auto cost = [&](const Weights& w) {
    return as_vector(w).dot(h * as_vector(w)) - 2 * g.dot(as_vector(w));
  };
  const std::vector<Weights>& simple = exponential_kernels();
  const BasisVector prior = as_vector(
      *std::min_element(simple.begin(), simple.end(),
                        [&](const Weights& a, const Weights& b) { return cost(a) < cost(b); }));
  const BasisVector pull = ridge * (prior.array() + kRidgeFloor).square().inverse();
  const double sum_weight = kSumWeight * h.trace() / kSize;
  KernelProgram program{h, g + pull.cwiseProduct(prior) + BasisVector::Constant(sum_weight)};
  program.a.array() += sum_weight;
  program.a.diagonal() += pull;
  return program;
}

}  // namespace

Kernel solve_kernel(const KernelEquations& equations, double offset_sigma, double ridge) {
  const BasisVector x = solve_program(kernel_program(equations, offset_sigma, ridge));
  Kernel kernel;
  for (int j = 0; j < kSize; ++j) kernel.weight[size_t(j)] = x(j) / x.sum();
  kernel.offset = WeightEquations(equations, offset_sigma).offset(as_vector(kernel.weight));
  KernelEquations::Vector all;
  all << as_vector(kernel.weight), kernel.offset;
  kernel.cost = equations.cost(all);
  return kernel;
}

}  // namespace lamella::fit
