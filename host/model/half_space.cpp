#include "model/half_space.h"

#include <algorithm>
#include <cmath>

namespace lamella::model {

namespace {

constexpr int kRows = HalfSpaceTable::kAbsorptions, kColumns = HalfSpaceTable::kFrequencies;

struct Row {
  double reflectance;
  std::array<double, kColumns> transfer;
};

// Five million photons; HalfSpace.DISABLED_IsWalkedAnew in the tests prints it.
constexpr std::array<Row, kRows> kTable{{
#include "model/half_space_table.inc"
}};

constexpr double kStep = HalfSpaceTable::log_absorption(1) - HalfSpaceTable::log_absorption(0);
constexpr double kColumnStep = HalfSpaceTable::log_frequency(1) - HalfSpaceTable::log_frequency(0);

// Where a figure lies among `count` nodes, and the weights of the four around it (Catmull and Rom),
// in from the ends.
struct Place {
  Place(double at, int count) {
    const double inside = std::clamp(at, 1.0, count - 2 - 1e-9);
    first = int(inside) - 1;
    const double t = inside - first - 1;
    weight = {((2 - t) * t - 1) * t / 2, ((3 * t - 5) * t * t + 2) / 2,
              ((4 - 3 * t) * t + 1) * t / 2, (t - 1) * t * t / 2};
  }
  int first;
  std::array<double, 4> weight;
};

Place place_of_absorption(double log_absorption) {
  return Place((log_absorption - HalfSpaceTable::log_absorption(0)) / kStep, kRows);
}

double mix(const Place& place, double (*value)(size_t)) {
  double sum = 0;
  for (size_t k = 0; k < 4; ++k) sum += place.weight[k] * value(size_t(place.first) + k);
  return sum;
}

}  // namespace

double half_space_reflectance(double log_absorption) {
  return std::exp(mix(place_of_absorption(log_absorption),
                      [](size_t row) { return std::log(kTable[row].reflectance); }));
}

double log_absorption_of(double reflectance) {
  double low = HalfSpaceTable::log_absorption(1), high = HalfSpaceTable::log_absorption(kRows - 2);
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (half_space_reflectance(middle) > reflectance ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

HalfSpaceTransfer::HalfSpaceTransfer(double log_absorption) {
  const Place place = place_of_absorption(log_absorption);
  for (size_t j = 0; j < size_t(kColumns); ++j) {
    row_[j] = 0;
    for (size_t k = 0; k < 4; ++k) {
      row_[j] += place.weight[k] * kTable[size_t(place.first) + k].transfer[j];
    }
  }
}

double HalfSpaceTransfer::operator()(double log_frequency) const {
  const Place place((log_frequency - HalfSpaceTable::log_frequency(0)) / kColumnStep, kColumns);
  double sum = 0;
  for (size_t k = 0; k < 4; ++k) sum += place.weight[k] * row_[size_t(place.first) + k];
  return sum;
}

}  // namespace lamella::model
