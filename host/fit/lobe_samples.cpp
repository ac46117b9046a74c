#include "fit/lobe_samples.h"

#include <algorithm>

#include "base/parallel.h"
#include "model/single_scattering.h"
#include "model/torrance_sparrow.h"

namespace lamella::fit {

namespace {

constexpr double kNarrowest = 0.1, kRatio = 1.22;
constexpr float kLobeMinCosine = 0.4f;  // towards light and camera: no model is good near grazing
constexpr float kMinVisible = 0.85f;  // share of the LEDs' light: little is left to interreflection
constexpr int kReachPx = 2;           // neighbours that GRADIENT_FULL is averaged over
constexpr int kBlockPx =
    16;  // tiles of the jackknife: wider than errors of the normals are correlated

struct Sampler {
  const Burst& burst;
  const Geometry& geometry;
  const Normals& normals;
  const LightVisibility& visibility;
  const SamplingPlan& plan;
  LedField field;
  MixtureTable mixture{};

  bool usable(int y, int x) const {
    if (is_clipped(burst.clipped_led, y, x) || is_clipped(burst.clipped_projector, y, x))
      return false;
    const Vec3 n = normals.specular(y, x);
    if (!is_finite(n) || !is_finite(geometry.position_mm(y, x))) return false;
    if (dot(n, geometry.to_camera(y, x)) < kLobeMinCosine) return false;
    if (dot(n, geometry.to_projector(y, x)) < kLobeMinCosine) return false;
    return visibility.projector_share(y, x) >= 0.999f;
  }

  void add_front(int y, int x, LobeSample* s) const {
    const Vec3 n = normals.specular(y, x), v = geometry.to_camera(y, x);
    const Vec3 l = geometry.to_projector(y, x), h = unit(l + v);
    const float n_l = dot(n, l), n_v = dot(n, v), v_h = dot(v, h);
    const float radiance = geometry.projector_irradiance(y, x);
    const SkinModel& skin = plan.skins[s->region];
    s->cos_h = dot(n, h);
    s->front_lobe = kPi * radiance * model::fresnel_reflectance(v_h) *
                    model::v_groove(s->cos_h, n_v, n_l, v_h) / n_v;
    s->front_single =
        kPi * radiance * n_l * model::single_scattering(skin.transmittance, skin.g, n, l, v);
    const Vec3 cross = burst.front.cross(y, x);
    s->front = burst.front.parallel(y, x) - cross;
    s->diffuse_reflectance = cross * (2.f / (n_l * radiance));
  }

  // False where shadows make up too much of it.
  bool add_full(int y, int x, const LedCell& cell, LobeSample* s) const {
    const Vec3 n = normals.specular(y, x), v = geometry.to_camera(y, x);
    const LedResponse led = led_response(cell, plan.skins[s->region], n, v);
    if (led.share < kMinVisible) return false;
    s->led_single = led.single;
    const float n_v = dot(n, v);
    for (size_t i = 0; i < cell.used; ++i) {
      const float n_l = cell.x[i] * n[0] + cell.y[i] * n[1] + cell.z[i] * n[2];
      if (n_l <= kLedHorizon || cell.reached[i] <= 0) continue;
      // v_groove() written out, with 1/(v.h) as the cell has it.
      const float n_h = 0.5f * (n_l + n_v) * cell.per_v_h[i];
      const float groove = std::min(1.f, 2.f * n_h * std::min(n_v, n_l) * cell.per_v_h[i]);
      const float weight = kPi / n_v * cell.reached[i] * cell.fresnel[i] * groove;
      const MixtureTable::Values members = mixture(n_h);
      for (size_t j = 0; j < kWidths; ++j) s->led_lobe[j] += weight * members[j];
    }
    add_neighbours(y, x, s);
    return true;
  }

  // c comes from `full` and multiplies the lobe: noise in it would take from the lobe and give to
  // single scattering. What a mean of neighbours is off by has no such preference. Variances come
  // from neighbours too: a weight that falls with the sample's own cross photograph would prefer
  // the samples whose S noise has raised.
  void add_neighbours(int y, int x, LobeSample* s) const {
    double sum = 0;
    Vec3 front_cross(0, 0, 0), full_cross(0, 0, 0);
    int count = 0;
    const cv::Size size = burst.regions.size();
    for (int v = std::max(0, y - kReachPx); v <= std::min(size.height - 1, y + kReachPx); ++v) {
      for (int u = std::max(0, x - kReachPx); u <= std::min(size.width - 1, x + kReachPx); ++u) {
        if (burst.regions(v, u) != burst.regions(y, x) || is_clipped(burst.clipped_led, v, u))
          continue;
        sum += double(mean(burst.full.parallel(v, u) - burst.full.cross(v, u)));
        front_cross += burst.front.cross(v, u);
        full_cross += burst.full.cross(v, u);
        ++count;
      }
    }
    const float per_pixel = 1.f / float(count);
    s->full = float(sum / count);
    const float full_radiance = mean(full_cross) * per_pixel;
    s->full_variance = (burst.led_parallel_noise.variance(full_radiance) +
                        burst.led_noise.variance(full_radiance)) /
                       3 * per_pixel;
    for (int c = 0; c < 3; ++c) {
      const float radiance = front_cross[c] * per_pixel;
      s->front_variance[c] =
          burst.front_parallel_noise.variance(radiance) + burst.projector_noise.variance(radiance);
    }
  }

  // Samples of one row of cells.
  void sample_cells(int cell_row, const std::vector<double>& share,
                    std::vector<LobeSample>* out) const {
    const int step = visibility.step_px();
    const cv::Size size = burst.regions.size();
    LedCell cell;
    for (int x0 = 0; x0 < size.width; x0 += step) {
      bool entered = false;
      for (int y = cell_row * step; y < std::min(size.height, (cell_row + 1) * step); ++y) {
        for (int x = x0; x < std::min(size.width, x0 + step); ++x) {
          const int label = burst.regions(y, x);
          if (label == 0 || !taken(y, x, share[size_t(label - 1)]) || !usable(y, x)) continue;
          const Vec3 n = normals.specular(y, x);
          if (!entered) {
            field.enter_cell(y, x, {geometry.position_mm(y, x), n, geometry.to_camera(y, x)},
                             &cell);
          }
          entered = true;
          field.enter_pixel(y, x, n, &cell);
          LobeSample s;
          s.pixel = {x, y};
          s.region = uint8_t(label - 1);
          s.block = uint8_t((y / kBlockPx * 3 + x / kBlockPx) % kBlocks);
          add_front(y, x, &s);
          if (add_full(y, x, cell, &s)) out->push_back(s);
        }
      }
    }
  }

  // An even share of pixels without a pattern of its own: a hash of the position.
  static bool taken(int y, int x, double share) {
    uint32_t h = uint32_t(y) * 0x9E3779B1u ^ uint32_t(x) * 0x85EBCA77u;
    h ^= h >> 15;
    h *= 0x2C1B3C6Du;
    h ^= h >> 13;
    return double(h) < share * 4294967296.0;
  }
};

}  // namespace

std::array<double, kWidths> mixture_widths() {
  std::array<double, kWidths> widths;
  for (size_t i = 0; i < kWidths; ++i) widths[i] = kNarrowest * std::pow(kRatio, double(i));
  return widths;
}

MixtureTable::MixtureTable() : cells_(kCells + 2) {
  const std::array<double, kWidths> widths = mixture_widths();
  for (int i = 0; i < kCells; ++i) {
    for (size_t j = 0; j < kWidths; ++j) {
      cells_[size_t(i)][j] = float(model::beckmann(1 - double(i) / kCells, widths[j]));
    }
  }
}

MixtureTable::Values MixtureTable::operator()(float cos_theta) const {
  const float x = std::clamp((1.f - cos_theta) * kCells, 0.f, float(kCells));
  const int i = int(x);
  const Values& a = cells_[size_t(i)];
  const Values& b = cells_[size_t(i) + 1];
  Values out;
  for (size_t j = 0; j < kWidths; ++j) out[j] = a[j] + (x - float(i)) * (b[j] - a[j]);
  return out;
}

std::vector<LobeSample> collect_samples(const Burst& burst, const Geometry& geometry,
                                        const Normals& normals, const LightVisibility& visibility,
                                        const SamplingPlan& plan) {
  std::vector<double> share(plan.skins.size(), 0.0);
  for (uint8_t label : burst.regions) {
    if (label > 0 && size_t(label) <= share.size()) share[size_t(label - 1)] += 1;
  }
  for (double& s : share) s = s > 0 ? std::min(1.0, plan.per_region / s) : 0.0;
  const LedField field(burst.session->stage, visibility);
  const Sampler sampler{burst, geometry, normals, visibility, plan, field};
  const int cell_rows = (burst.regions.rows - 1) / visibility.step_px() + 1;
  std::vector<std::vector<LobeSample>> rows(static_cast<size_t>(cell_rows));
  parallel_for(cell_rows, [&](int i) { sampler.sample_cells(i, share, &rows[size_t(i)]); });
  std::vector<LobeSample> samples;
  for (const auto& row : rows) samples.insert(samples.end(), row.begin(), row.end());
  return samples;
}

}  // namespace lamella::fit
