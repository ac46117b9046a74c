#include "fit/stripe_shape.h"

#include <algorithm>
#include <cmath>

namespace lamella::fit {

namespace {

constexpr int kHighestHarmonic = 9;  // the next is below 1e-3 once a pixel's width has blurred it

double row_centre(int row) { return (row + 0.5) / StripeBins::kFrequencies; }

double column_centre(int column) { return (column + 0.5) / StripeBins::kPhases; }

// Stripes half white, half black, about their mean: (2/pi) sum over odd h of
// (-1)^((h-1)/2)/h cos(2 pi h phase).
double harmonic(int h, double phase) {
  return 2 / M_PI * (h % 4 == 1 ? 1.0 : -1.0) / h * std::cos(2 * M_PI * h * phase);
}

}  // namespace

int StripeBins::row(float frequency) {
  return std::clamp(int(frequency * kFrequencies), 0, kFrequencies - 1);
}

int StripeBins::column(float phase) {
  return std::min(int((phase - std::floor(phase)) * kPhases), kPhases - 1);
}

StripeBins& StripeBins::operator+=(const StripeBins& other) {
  for (size_t i = 0; i < cells_.size(); ++i) {
    cells_[i].weight += other.cells_[i].weight;
    cells_[i].value += other.cells_[i].value;
    cells_[i].square += other.cells_[i].square;
    cells_[i].count += other.cells_[i].count;
  }
  return *this;
}

KernelEquations StripeBins::equations(double highest_cycles_per_mm) const {
  KernelEquations sum;
  for (int f = 0; f < kFrequencies; ++f) {
    for (int p = 0; p < kPhases; ++p) {
      const Cell& cell = cells_[size_t(f * kPhases + p)];
      if (cell.weight <= 0) continue;
      KernelEquations::Vector row = KernelEquations::Vector::Zero();
      for (int h = 1; h <= kHighestHarmonic; h += 2) {
        const double amplitude = harmonic(h, column_centre(p));
        const double frequency = h * row_centre(f) * highest_cycles_per_mm;
        for (int j = 0; j < GaussianBasis::kSize; ++j) {
          row(j) += amplitude * GaussianBasis::transfer(j, frequency);
        }
      }
      sum.add(row, cell.value / cell.weight, cell.weight, cell.count);
      sum.square += cell.square - cell.value * cell.value / cell.weight;
    }
  }
  return sum;
}

StripeShape::StripeShape(const GaussianBasis::Weights& kernel, double highest_cycles_per_mm) {
  for (int f = 0; f < StripeBins::kFrequencies; ++f) {
    std::array<double, kHighestHarmonic + 1> share{};
    double half_swing = 0;
    for (int h = 1; h <= kHighestHarmonic; h += 2) {
      for (int j = 0; j < GaussianBasis::kSize; ++j) {
        share[size_t(h)] += kernel[size_t(j)] * GaussianBasis::transfer(
                                                    j, h * row_centre(f) * highest_cycles_per_mm);
      }
      half_swing += harmonic(h, 0) * share[size_t(h)];
    }
    swing_.push_back(float(2 * half_swing));
    for (int p = 0; p < StripeBins::kPhases; ++p) {
      double value = 0;
      for (int h = 1; h <= kHighestHarmonic; h += 2) {
        value += harmonic(h, column_centre(p)) * share[size_t(h)];
      }
      shape_.push_back(float(value / std::max(2 * half_swing, 1e-6)));
    }
  }
}

}  // namespace lamella::fit
