#include "model/transmittance.h"

#include <algorithm>
#include <cmath>

#include "model/torrance_sparrow.h"

namespace lamella::model {

namespace {

constexpr float kGrazing = 0.02f;  // eq. 1 has no limit at the horizon: the table is flat below

// Of half a turn about the normal; the other half is its mirror image.
constexpr size_t kAzimuths = 24;
using HalfTurn = std::array<float, kAzimuths>;

HalfTurn half_turn() {
  HalfTurn cosines;
  for (size_t k = 0; k < kAzimuths; ++k) {
    cosines[k] = std::cos(kPi * (float(k) + 0.5f) / float(kAzimuths));
  }
  return cosines;
}

}  // namespace

double directional_reflectance(const LobeTable& lobe, double n_w) {
  // Over the half vector, where the lobe is narrow: d(omega_l) = 4 (v.h) d(omega_h).
  constexpr int kPolar = 48;
  static const HalfTurn kCosAzimuth = half_turn();
  const float cos_v = float(n_w), sin_v = float(std::sqrt(1 - n_w * n_w));
  double sum = 0;
  for (int i = 0; i < kPolar; ++i) {
    // Cells of equal width in sqrt(1 - cos theta), nearly equal in theta, fine where p is high.
    const double from = double(i) / kPolar, to = double(i + 1) / kPolar;
    const float cos_h = float(1 - 0.5 * (from * from + to * to));
    const float sin_h = std::sqrt(1 - cos_h * cos_h);
    const float p = lobe.density(cos_h);
    if (p <= 0) continue;
    HalfTurn reflected;
    for (size_t k = 0; k < kAzimuths; ++k) {
      const float v_h = sin_v * sin_h * kCosAzimuth[k] + cos_v * cos_h;
      const float n_l = 2 * v_h * cos_h - cos_v;
      const float share = fresnel_reflectance(v_h) * v_groove(cos_h, cos_v, n_l, v_h) * 4 * v_h;
      reflected[k] = v_h > 0 && n_l > 0 ? share : 0.f;
    }
    double ring = 0;
    for (float r : reflected) ring += double(r);
    sum += p * ring / double(kAzimuths) * 2 * double(kPi) * (to * to - from * from);
  }
  return sum / n_w;
}

TransmittanceTable::TransmittanceTable() {
  for (int i = 0; i <= kCells; ++i) {
    const float n_w = std::max(kGrazing, float(i) / kCells);
    cells_[size_t(i)] = 1.f - fresnel_reflectance(n_w);
  }
}

TransmittanceTable::TransmittanceTable(const LobeTable& lobe, double c) {
  for (int i = 0; i <= kCells; ++i) {
    const double n_w = std::max(double(kGrazing), double(i) / kCells);
    cells_[size_t(i)] = float(std::clamp(1 - c * directional_reflectance(lobe, n_w), 0.0, 1.0));
  }
}

}  // namespace lamella::model
