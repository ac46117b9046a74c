#include "fit/led_response.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "model/single_scattering.h"
#include "model/torrance_sparrow.h"

namespace lamella::fit {

namespace {

constexpr int kFacingBins = 64;

// LEDs by the cosine between them and `normal`, falling: an upper bound of it, to a 32nd, and the
// LED's number. Counted into bins, as to sort them for every cell takes as long as it saves.
std::vector<std::pair<float, size_t>> by_facing(const std::vector<Vec3>& direction,
                                                const Vec3& normal) {
  std::vector<int> bin(direction.size());
  std::array<size_t, kFacingBins + 1> begin{};
  for (size_t i = 0; i < bin.size(); ++i) {
    const float away = 0.5f * (1.f - dot(direction[i], normal));
    bin[i] = std::clamp(int(away * kFacingBins), 0, kFacingBins - 1);
    ++begin[size_t(bin[i]) + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::pair<float, size_t>> order(bin.size());
  for (size_t i = 0; i < bin.size(); ++i) {
    order[begin[size_t(bin[i])]++] = {1.f - 2.f * float(bin[i]) / kFacingBins, i};
  }
  return order;
}

// Room for `count` lights and the padding; what is there is written over.
void make_room(size_t count, LedCell* cell) {
  const size_t padded = (count + LedCell::kLanes - 1) / LedCell::kLanes * LedCell::kLanes;
  for (auto* values : {&cell->x, &cell->y, &cell->z, &cell->radiance, &cell->share[0],
                       &cell->share[1], &cell->share[2], &cell->share[3], &cell->l_v,
                       &cell->per_v_h, &cell->fresnel, &cell->reached}) {
    values->resize(padded);
  }
  cell->facing.resize(count);
}

void see_from_camera(const Vec3& to_camera, LedCell* cell) {
  for (size_t i = 0; i < cell->x.size(); ++i) {
    cell->l_v[i] =
        cell->x[i] * to_camera[0] + cell->y[i] * to_camera[1] + cell->z[i] * to_camera[2];
    const float v_h = std::sqrt(std::max(1e-6f, 0.5f + 0.5f * cell->l_v[i]));
    cell->per_v_h[i] = 1.f / v_h;
    cell->fresnel[i] = model::fresnel_reflectance(v_h);
  }
}

}  // namespace

void LedField::enter_cell(int y, int x, const SurfacePoint& point, LedCell* cell) const {
  const LightVisibility::Corners corners = visibility_.corners(y, x);
  const size_t count = stage_.leds().size();
  make_room(count, cell);
  std::vector<Vec3> direction(count);
  for (size_t led = 0; led < count; ++led) {
    direction[led] = stage_.direction_from(led, point.position_mm);
  }
  const auto order = by_facing(direction, point.normal);
  cell->normal = point.normal;
  size_t first_hidden = cell->x.size();
  for (size_t i = 0; i < cell->x.size(); ++i) {
    const auto [facing, led] = order[std::min(i, count - 1)];
    cell->x[i] = direction[led][0];
    cell->y[i] = direction[led][1];
    cell->z[i] = direction[led][2];
    cell->radiance[i] = i < count ? mean(stage_.irradiance(led, point.position_mm)) : 0.f;
    if (i < count) cell->facing[i] = facing;
    const std::array<float, 4> reaches = visibility_.reaches(corners, led);
    for (size_t k = 0; k < 4; ++k) {
      cell->share[k][i] = reaches[k];
      if (reaches[k] < 1) first_hidden = std::min(first_hidden, i);
    }
  }
  cell->open = first_hidden / LedCell::kLanes * LedCell::kLanes;
  see_from_camera(point.to_camera, cell);
  cell->reached = cell->radiance;
}

void LedField::enter_pixel(int y, int x, const Vec3& n, LedCell* cell) const {
  // n.l is at most |n - n'| more than n'.l: behind these no light is above the horizon.
  const float least = kLedHorizon - length(n - cell->normal);
  const auto end = std::partition_point(cell->facing.begin(), cell->facing.end(),
                                        [&](float facing) { return facing > least; });
  const auto above = size_t(end - cell->facing.begin());
  cell->used = (above + LedCell::kLanes - 1) / LedCell::kLanes * LedCell::kLanes;
  const std::array<float, 4> w = visibility_.weights(y, x);
  const float* share[4] = {cell->share[0].data(), cell->share[1].data(), cell->share[2].data(),
                           cell->share[3].data()};
  for (size_t i = cell->open; i < cell->used; ++i) {
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
  for (size_t i = 0; i < cell.used; i += kCellLanes) {
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
