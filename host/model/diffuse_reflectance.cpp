#include "model/diffuse_reflectance.h"

#include <limits>

namespace lamella::model {

namespace {

constexpr int kCells = 2048;

// Bisection needs no care at either end, where eq. 8 is steep in alpha' or flat in s.
double s_from_reflectance(double reflectance) {
  double low = 0, high = std::sqrt(3.0);
  for (int i = 0; i < 52; ++i) {
    const double middle = 0.5 * (low + high);
    (diffuse_reflectance_at_s(middle) > reflectance ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

std::optional<double> alpha_from_reflectance(double reflectance) {
  if (!(reflectance < 1)) return std::nullopt;
  if (reflectance <= 0) return 0.0;
  return alpha_from_s(s_from_reflectance(reflectance));
}

AlphaTable::AlphaTable() : s_(kCells + 1) {
  for (int i = 0; i <= kCells; ++i) s_[size_t(i)] = float(s_from_reflectance(i / double(kCells)));
}

float AlphaTable::alpha(float reflectance) const {
  if (!(reflectance < 1.f)) return std::numeric_limits<float>::quiet_NaN();
  if (reflectance <= 0.f) return 0.f;
  const float x = reflectance * kCells;
  const int i = int(x);
  const float s = s_[size_t(i)] + (x - float(i)) * (s_[size_t(i) + 1] - s_[size_t(i)]);
  return 1.f - s * s / 3.f;
}

}  // namespace lamella::model
