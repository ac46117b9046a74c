#include "fit/led_response.h"

#include "model/single_scattering.h"
#include "model/torrance_sparrow.h"

namespace lamella::fit {

namespace {

constexpr float kMinCosine = 0.02f;  // eq. 1 has no limit at the horizon

}  // namespace

void LightsAtPoint::clear() {
  x.clear();
  y.clear();
  z.clear();
  radiance.clear();
  count = 0;
}

void LightsAtPoint::add(const Vec3& direction, float radiance_facing) {
  x.push_back(direction[0]);
  y.push_back(direction[1]);
  z.push_back(direction[2]);
  radiance.push_back(radiance_facing);
  ++count;
}

void LightsAtPoint::pad() {
  while (x.size() % kLanes != 0) {
    x.push_back(x.empty() ? 0.f : x.front());
    y.push_back(y.empty() ? 0.f : y.front());
    z.push_back(z.empty() ? 1.f : z.front());
    radiance.push_back(0.f);
  }
}

void LedField::enter_cell(int y, int x, const Vec3& position_mm, Cell* cell) const {
  const LightVisibility::Corners corners = visibility_.corners(y, x);
  const size_t count = stage_.leds().size();
  cell->direction.resize(count);
  cell->radiance.resize(count);
  for (auto& share : cell->share) share.resize(count);
  for (size_t i = 0; i < count; ++i) {
    cell->direction[i] = stage_.direction_from(i, position_mm);
    cell->radiance[i] = mean(stage_.irradiance(i, position_mm));
    for (size_t k = 0; k < 4; ++k) cell->share[k][i] = float(corners.node[k][i]);
  }
}

float LedField::lights_at(const Cell& cell, int y, int x, const Vec3& normal,
                          LightsAtPoint* lights) const {
  const LightVisibility::Corners corners = visibility_.corners(y, x);
  float open = 0, reached = 0;
  lights->clear();
  for (size_t i = 0; i < cell.direction.size(); ++i) {
    const float n_l = dot(cell.direction[i], normal);
    if (n_l < kMinCosine) continue;
    float share = 0;
    for (size_t k = 0; k < 4; ++k) share += corners.weight[k] * cell.share[k][i];
    open += n_l * cell.radiance[i];
    reached += n_l * cell.radiance[i] * share;
    if (share > 0) lights->add(cell.direction[i], share * cell.radiance[i]);
  }
  lights->pad();
  return open > 0 ? reached / open : 0.f;
}

LedResponse led_response(const LightsAtPoint& lights, const SkinModel& skin, const Vec3& n,
                         const Vec3& v) {
  constexpr size_t kLanes = LightsAtPoint::kLanes;
  const float n_v = dot(n, v);
  if (n_v < kMinCosine) return {};
  const float v_inside = model::refracted_cosine(n_v);
  float lobe[kLanes] = {}, single[kLanes] = {};
  for (size_t i = 0; i < lights.x.size(); i += kLanes) {
    for (size_t k = 0; k < kLanes; ++k) {
      const float lx = lights.x[i + k], ly = lights.y[i + k], lz = lights.z[i + k];
      const float n_l = lx * n[0] + ly * n[1] + lz * n[2];
      const float l_v = lx * v[0] + ly * v[1] + lz * v[2];
      const float v_h = std::sqrt(std::max(1e-6f, 0.5f + 0.5f * l_v));
      const float n_h = 0.5f * (n_l + n_v) / v_h;
      lobe[k] += lights.radiance[i + k] * model::lobe_times_cosine(skin.lobe, n_h, n_v, n_l, v_h);
      const float l_inside = model::refracted_cosine(n_l);
      const float cosine = model::scattering_cosine(l_v, n_l, n_v, l_inside, v_inside);
      single[k] += lights.radiance[i + k] * n_l * skin.transmittance(n_l) *
                   model::henyey_greenstein(cosine, skin.g) / (l_inside + v_inside);
    }
  }
  LedResponse sum;
  for (size_t k = 0; k < kLanes; ++k) {
    sum.lobe += kPi * lobe[k];
    sum.single += kPi * single[k];
  }
  sum.single *= skin.transmittance(n_v) * float(model::alpha_from_amplitude(1.0, double(skin.g)));
  return sum;
}

}  // namespace lamella::fit
