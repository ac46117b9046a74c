// The brightness that stripes leave on skin, against phase: sharp stripes, blurred by the region's
// scattering kernel. Its shape is needed to find, from four samples, the swing that a continuous
// shift would show (physics.md: Shallow and deep).
#pragma once

#include <vector>

#include "fit/kernel_equations.h"

namespace lamella::fit {

// Photographs that were averaged over blocks of pixels, across the stripes.
struct StripeBlocks {
  int pixels = 1;               // of a block
  double periods_per_px = 0.1;  // of the stripes

  // Share of a wave of `cycles` a period of the stripes that the mean of a block's pixels keeps:
  // sin(pi n x)/(n sin(pi x)), x cycles a pixel.
  double transfer(int cycles) const;
};

// Rows of the equations: what each Gaussian leaves of the stripes, about their mean.
class StripeDesign {
 public:
  static constexpr int kFrequencies = 24, kPhases = 64;

  // `highest_cycles_per_mm`: the frequency at the table's end. Rows are what blocks show.
  explicit StripeDesign(double highest_cycles_per_mm, const StripeBlocks& blocks = {});

  // In the weights of the kernel; the offset's column stays empty (a stripe and its complement sum
  // to the evenly lit photograph, so there is none).
  const KernelEquations::Vector& row(int frequency, int phase) const {
    return rows_[size_t(frequency * kPhases + phase)];
  }

  // The same in the middle of a white stripe, as a pixel shows it.
  const KernelEquations::Vector& middle(int frequency) const { return middle_[size_t(frequency)]; }

 private:
  std::vector<KernelEquations::Vector> rows_, middle_;
};

// Samples of one region and channel, I/(FRONT - BLACK) - 1/2, gathered by the stripes' frequency on
// the surface and by phase (0: the middle of a white stripe).
class StripeBins {
 public:
  static constexpr int kFrequencies = StripeDesign::kFrequencies;
  static constexpr int kPhases = StripeDesign::kPhases;

  StripeBins() : cells_(size_t(kFrequencies * kPhases)) {}

  void add(int row, int column, float value, float weight) {
    Cell& cell = cells_[size_t(row * kPhases + column)];
    cell.weight += weight;
    cell.value += weight * value;
    cell.square += weight * value * value;
    cell.count += 1;
  }
  StripeBins& operator+=(const StripeBins& other);

  KernelEquations equations(const StripeDesign& design) const;

  static int row(float frequency);  // in units of the table's highest, 0 to 1
  static int column(float phase);   // in turns

 private:
  struct Cell {
    double weight = 0, value = 0, square = 0, count = 0;
  };
  std::vector<Cell> cells_;
};

// The table for one region and channel.
class StripeShape {
 public:
  StripeShape() = default;
  StripeShape(const GaussianBasis::Weights& kernel, const StripeDesign& design);

  // Brightness of swing 1 about 0, at a frequency row and a phase column.
  float at(int row, int column) const { return shape_[size_t(row * StripeBins::kPhases + column)]; }

  // d at/d phase, per turn.
  float slope(int row, int column) const {
    const int last = StripeBins::kPhases - 1;
    return 0.5f * StripeBins::kPhases *
           (at(row, (column + 1) & last) - at(row, (column - 1) & last));
  }

  // The swing that the kernel itself would show: A/(FRONT - BLACK).
  float swing(int row) const { return swing_[size_t(row)]; }

 private:
  std::vector<float> shape_, swing_;
};

}  // namespace lamella::fit
