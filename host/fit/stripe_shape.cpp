#include "fit/stripe_shape.h"

#include <algorithm>
#include <cmath>

namespace lamella::fit {

namespace {

constexpr int kHighestHarmonic = 63;  // a square wave that the narrowest Gaussian blurs
constexpr double kNegligibleTransfer = 1e-5;
constexpr double kWholeCycle = 1e-9;  // pixels that all see the same of a wave

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

double StripeBlocks::transfer(int cycles) const {
  const double turn = M_PI * cycles * periods_per_px, one = std::sin(turn);
  return std::abs(one) < kWholeCycle ? 1 : std::sin(pixels * turn) / (pixels * one);
}

StripeDesign::StripeDesign(double highest_cycles_per_mm, const StripeBlocks& blocks) {
  const auto row_at = [&](int frequency, double phase, const StripeBlocks& seen_by) {
    KernelEquations::Vector row = KernelEquations::Vector::Zero();
    for (int j = 0; j < GaussianBasis::kSize; ++j) {
      for (int h = 1; h <= kHighestHarmonic; h += 2) {
        const double transfer =
            GaussianBasis::transfer(j, h * row_centre(frequency) * highest_cycles_per_mm);
        if (transfer < kNegligibleTransfer) break;
        row(j) += transfer * seen_by.transfer(h) * harmonic(h, phase);
      }
    }
    return row;
  };
  for (int f = 0; f < kFrequencies; ++f) {
    for (int p = 0; p < kPhases; ++p) rows_.push_back(row_at(f, column_centre(p), blocks));
    middle_.push_back(row_at(f, 0, {}));
  }
}

KernelEquations StripeBins::equations(const StripeDesign& design) const {
  KernelEquations sum;
  for (int f = 0; f < kFrequencies; ++f) {
    for (int p = 0; p < kPhases; ++p) {
      const Cell& cell = cells_[size_t(f * kPhases + p)];
      if (cell.weight <= 0) continue;
      sum.add(design.row(f, p), cell.value / cell.weight, cell.weight, cell.count);
      sum.square += cell.square - cell.value * cell.value / cell.weight;
    }
  }
  return sum;
}

StripeShape::StripeShape(const GaussianBasis::Weights& kernel, const StripeDesign& design) {
  KernelEquations::Vector weights = KernelEquations::Vector::Zero();
  std::copy(kernel.begin(), kernel.end(), weights.data());
  for (int f = 0; f < StripeBins::kFrequencies; ++f) {
    const double swing = 2 * design.middle(f).dot(weights);
    swing_.push_back(float(swing));
    for (int p = 0; p < StripeBins::kPhases; ++p) {
      shape_.push_back(float(design.row(f, p).dot(weights) / std::max(swing, 1e-6)));
    }
  }
}

}  // namespace lamella::fit
