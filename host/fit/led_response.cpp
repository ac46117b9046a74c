#include "fit/led_response.h"

#include <algorithm>
#include <numeric>

#include "model/single_scattering.h"
#include "model/torrance_sparrow.h"

namespace lamella::fit {

LedField::LedField(const LightStage& stage, const LightVisibility& visibility)
    : stage_(stage), visibility_(visibility), order_(stage.leds().size()) {
  std::iota(order_.begin(), order_.end(), size_t(0));
  std::sort(order_.begin(), order_.end(), [&](size_t a, size_t b) {
    return stage.leds()[a].direction[2] > stage.leds()[b].direction[2];
  });
}

void LedField::enter_cell(int y, int x, const Vec3& position_mm, const Vec3& to_camera,
                          LedCell* cell) const {
  const LightVisibility::Corners corners = visibility_.corners(y, x);
  const size_t count = order_.size();
  const size_t padded = (count + LedCell::kLanes - 1) / LedCell::kLanes * LedCell::kLanes;
  for (auto* values : {&cell->x, &cell->y, &cell->z, &cell->radiance, &cell->share[0],
                       &cell->share[1], &cell->share[2], &cell->share[3], &cell->l_v,
                       &cell->per_v_h, &cell->fresnel, &cell->reached}) {
    values->assign(padded, 0.f);
  }
  for (size_t i = 0; i < padded; ++i) {
    const size_t led = order_[std::min(i, count - 1)];
    const Vec3 direction = stage_.direction_from(led, position_mm);
    cell->x[i] = direction[0];
    cell->y[i] = direction[1];
    cell->z[i] = direction[2];
    cell->l_v[i] = dot(direction, to_camera);
    const float v_h = std::sqrt(std::max(1e-6f, 0.5f + 0.5f * cell->l_v[i]));
    cell->per_v_h[i] = 1.f / v_h;
    cell->fresnel[i] = model::fresnel_reflectance(v_h);
    if (i >= count) continue;
    cell->radiance[i] = mean(stage_.irradiance(led, position_mm));
    for (size_t k = 0; k < 4; ++k) cell->share[k][i] = float(corners.node[k][led]);
  }
}

void LedField::enter_pixel(int y, int x, LedCell* cell) const {
  const LightVisibility::Corners corners = visibility_.corners(y, x);
  const float* share[4] = {cell->share[0].data(), cell->share[1].data(), cell->share[2].data(),
                           cell->share[3].data()};
  const float* w = corners.weight;
  for (size_t i = 0; i < cell->reached.size(); ++i) {
    cell->reached[i] = cell->radiance[i] * (w[0] * share[0][i] + w[1] * share[1][i] +
                                            w[2] * share[2][i] + w[3] * share[3][i]);
  }
}

namespace {

constexpr size_t kCellLanes = LedCell::kLanes;
using CellLanes = std::array<float, kCellLanes>;

// Look-ups one at a time: as gather instructions, which the compiler prefers, they take several
// times as long on processors that are mended against data sampling.
#if defined(__GNUC__) && !defined(__clang__)
__attribute__((noinline, optimize("no-tree-vectorize")))
#endif
void look_up(const SkinModel& skin, const CellLanes& n_h, const CellLanes& n_l, CellLanes* p, CellLanes* rho) {
  for (size_t k = 0; k < kCellLanes; ++k) {
    (*p)[k] = skin.lobe.density(n_h[k]);
    (*rho)[k] = skin.transmittance(n_l[k]);
  }
}

float sum_of(const CellLanes& lanes) {
  float sum = 0;
  for (float lane : lanes) sum += lane;
  return sum;
}

}  // namespace

LedResponse led_response(const LedCell& cell, const SkinModel& skin, const Vec3& n, const Vec3& v) {
  const float n_v = dot(n, v);
  if (n_v < kLedHorizon) return {};
  const float v_inside = model::refracted_cosine(n_v);
  CellLanes lobe{}, single{}, reached{}, open{};
  for (size_t i = 0; i < cell.reached.size(); i += kCellLanes) {
    CellLanes n_l, n_h, surface, inside, p, rho;
    float any = 0;
    for (size_t k = 0; k < kCellLanes; ++k) {
      const size_t led = i + k;
      const float above = cell.x[led] * n[0] + cell.y[led] * n[1] + cell.z[led] * n[2];
      const float up = above > kLedHorizon ? 1.f : 0.f;
      const float radiance = up * cell.reached[led];
      // v_groove() and henyey_greenstein() written out, with their divisions taken together.
      n_l[k] = std::max(above, kLedHorizon);
      n_h[k] = 0.5f * (n_l[k] + n_v) * cell.per_v_h[led];
      const float groove = 2.f * n_h[k] * std::min(n_v, n_l[k]) * cell.per_v_h[led];
      surface[k] = radiance * cell.fresnel[led] * std::min(1.f, groove);
      const float l_inside = model::refracted_cosine(n_l[k]);
      const float cosine = model::scattering_cosine(cell.l_v[led], n_l[k], n_v, l_inside, v_inside);
      const float spread = 1.f + skin.g * skin.g - 2.f * skin.g * cosine;
      inside[k] = radiance * n_l[k] / (spread * std::sqrt(spread) * (l_inside + v_inside));
      reached[k] += radiance * n_l[k];
      any += radiance;
      open[k] += up * cell.radiance[led] * n_l[k];
    }
    if (any == 0.f) continue;
    look_up(skin, n_h, n_l, &p, &rho);
    for (size_t k = 0; k < kCellLanes; ++k) {
      lobe[k] += surface[k] * p[k];
      single[k] += inside[k] * rho[k];
    }
  }
  LedResponse sum;
  sum.lobe = kPi / n_v * sum_of(lobe);
  // pi E f (n.l) with f of eq. 3 and alpha of amplitude 1: the phase function's (1-g^2)/(4 pi) too.
  sum.single = 0.25f * (1 - skin.g * skin.g) * skin.transmittance(n_v) *
               float(model::alpha_from_amplitude(1.0, double(skin.g))) * sum_of(single);
  const float all_open = sum_of(open);
  sum.share = all_open > 0 ? sum_of(reached) / all_open : 0.f;
  return sum;
}

}  // namespace lamella::fit
