#include "fit/led_response.h"

#include <algorithm>
#include <numeric>

#include "model/single_scattering.h"
#include "model/torrance_sparrow.h"

namespace lamella::fit {

namespace {

constexpr int kFacingBins = 64;

// Numbers of LEDs by the cosine between them and `normal`, falling, and an upper bound of it, to a
// 32nd. Counted into bins, as to sort them for every cell takes as long as it saves.
void sort_by_facing(const std::vector<SeenLed>& leds, const Vec3& normal, LedCell* cell) {
  const auto bin_of = [&](const SeenLed& led) {
    const float away = 0.5f * (1.f - dot(led.direction, normal));
    return size_t(std::clamp(int(away * kFacingBins), 0, kFacingBins - 1));
  };
  std::array<size_t, kFacingBins + 1> begin{};
  for (const SeenLed& led : leds) ++begin[bin_of(led) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  cell->led.resize(leds.size());
  cell->facing.resize(leds.size());
  for (size_t number = 0; number < leds.size(); ++number) {
    const size_t bin = bin_of(leds[number]);
    const size_t place = begin[bin]++;
    cell->led[place] = number;
    cell->facing[place] = 1.f - 2.f * float(bin) / kFacingBins;
  }
}

size_t whole_lanes(size_t count) {
  return (count + LedCell::kLanes - 1) / LedCell::kLanes * LedCell::kLanes;
}

void make_room(size_t count, LedCell* cell) {
  for (auto* values : {&cell->x, &cell->y, &cell->z, &cell->radiance, &cell->share[0],
                       &cell->share[1], &cell->share[2], &cell->share[3], &cell->l_v,
                       &cell->per_v_h, &cell->fresnel, &cell->reached}) {
    values->resize(whole_lanes(count));
  }
}

// Of one register of lights.
void see_from_camera(size_t first, LedCell* cell) {
  const Vec3& v = cell->point.to_camera;
  std::array<float, LedCell::kLanes> l_v, per_v_h, fresnel;
  for (size_t k = 0; k < LedCell::kLanes; ++k) {
    const size_t i = first + k;
    l_v[k] = cell->x[i] * v[0] + cell->y[i] * v[1] + cell->z[i] * v[2];
    const float v_h = std::sqrt(std::max(1e-6f, 0.5f + 0.5f * l_v[k]));
    per_v_h[k] = 1.f / v_h;
    fresnel[k] = model::fresnel_reflectance(v_h);
  }
  std::copy(l_v.begin(), l_v.end(), &cell->l_v[first]);
  std::copy(per_v_h.begin(), per_v_h.end(), &cell->per_v_h[first]);
  std::copy(fresnel.begin(), fresnel.end(), &cell->fresnel[first]);
}

}  // namespace

LedField::LedField(const LightStage& stage, const LightVisibility& visibility)
    : stage_(stage), visibility_(visibility) {
  const std::vector<Led>& leds = stage.leds();
  const bool all_far =
      std::all_of(leds.begin(), leds.end(), [](const Led& led) { return led.distance_mm <= 0; });
  if (all_far) far_ = seen_from({0, 0, 0});
}

std::vector<SeenLed> LedField::seen_from(const Vec3& x_mm) const {
  std::vector<SeenLed> seen(stage_.leds().size());
  for (size_t i = 0; i < seen.size(); ++i) {
    seen[i] = {stage_.direction_from(i, x_mm), mean(stage_.irradiance(i, x_mm))};
  }
  return seen;
}

void LedField::enter_cell(int y, int x, const SurfacePoint& point, LedCell* cell) const {
  cell->point = point;
  cell->corners = visibility_.corners(y, x);
  if (far_.empty()) cell->near = seen_from(point.position_mm);
  make_room(stage_.leds().size(), cell);
  sort_by_facing(far_.empty() ? cell->near : far_, point.normal, cell);
  cell->known = cell->open = 0;
}

// `count`: whole lanes.
void LedField::know(size_t count, LedCell* cell) const {
  const std::vector<SeenLed>& leds = far_.empty() ? cell->near : far_;
  for (size_t i = cell->known; i < count; ++i) {
    const size_t number = cell->led[std::min(i, leds.size() - 1)];
    const SeenLed& led = leds[number];
    cell->x[i] = led.direction[0];
    cell->y[i] = led.direction[1];
    cell->z[i] = led.direction[2];
    cell->radiance[i] = cell->reached[i] = i < leds.size() ? led.radiance : 0.f;
    const std::array<float, 4> reaches = visibility_.reaches(cell->corners, number);
    for (size_t k = 0; k < 4; ++k) cell->share[k][i] = reaches[k];
    const bool open = reaches[0] + reaches[1] + reaches[2] + reaches[3] == 4;
    if (open && cell->open == i) ++cell->open;
  }
  for (size_t i = cell->known; i < count; i += LedCell::kLanes) see_from_camera(i, cell);
  cell->known = count;
}

void LedField::enter_pixel(int y, int x, const Vec3& n, LedCell* cell) const {
  // n.l is at most |n - n'| more than n'.l: behind these no light is above the horizon.
  const float least = kLedHorizon - length(n - cell->point.normal);
  const auto end = std::partition_point(cell->facing.begin(), cell->facing.end(),
                                        [&](float facing) { return facing > least; });
  cell->used = whole_lanes(size_t(end - cell->facing.begin()));
  if (cell->used > cell->known) know(cell->used, cell);
  const std::array<float, 4> w = visibility_.weights(y, x);
  const float* share[4] = {cell->share[0].data(), cell->share[1].data(), cell->share[2].data(),
                           cell->share[3].data()};
  for (size_t i = cell->open / LedCell::kLanes * LedCell::kLanes; i < cell->used; ++i) {
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
void look_up(const SkinModel& skin, const CellLanes& n_h, const CellLanes& n_l, CellLanes* p,
             CellLanes* rho) {
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
