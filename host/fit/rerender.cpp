#include "fit/rerender.h"

#include <algorithm>

#include "base/parallel.h"
#include "fit/led_irradiance.h"

namespace lamella::fit {

namespace {

constexpr float kConfident = 0.5f;
constexpr float kRerenderMinCosine = 0.1f;

// Squares of residual and photograph, summed.
struct Sums {
  double residual = 0, photograph = 0;
  Vec3d drawn_light{0, 0, 0}, taken_light{0, 0, 0};

  void add(const Vec3& drawn, const Vec3& taken) {
    drawn_light += Vec3d(drawn);
    taken_light += Vec3d(taken);
    const Vec3 d = drawn - taken;
    residual += double(dot(d, d));
    photograph += double(dot(taken, taken));
  }
  void add(const Sums& other) {
    residual += other.residual;
    photograph += other.photograph;
    drawn_light += other.drawn_light;
    taken_light += other.taken_light;
  }
  std::array<double, 3> off() const {
    std::array<double, 3> share;
    for (int c = 0; c < 3; ++c) {
      share[size_t(c)] = taken_light[c] > 0 ? drawn_light[c] / taken_light[c] - 1 : std::nan("");
    }
    return share;
  }
  double relative() const {
    return photograph > 0 ? std::sqrt(residual / photograph) : std::nan("");
  }
};

struct AllSums {
  Sums front_parallel, front_cross, full_parallel, full_cross;

  void add(const AllSums& other) {
    front_parallel.add(other.front_parallel);
    front_cross.add(other.front_cross);
    full_parallel.add(other.full_parallel);
    full_cross.add(other.full_cross);
  }
};

class Rerenderer {
 public:
  Rerenderer(const Burst& burst, const FittedLayers& layers)
      : burst_(burst),
        layers_(layers),
        leds_(led_irradiance_over(burst.session->stage, layers.geometry.position_mm,
                                  burst.quality.irradiance_cells)) {}

  AllSums row(int y) const {
    AllSums sums;
    for (int x = 0; x < burst_.regions.cols; ++x) {
      if (!burst_.regions(y, x) || !is_finite(layers_.geometry.position_mm(y, x))) continue;
      if (!is_clipped(burst_.clipped_projector, y, x)) add_front(y, x, &sums);
      if (!is_clipped(burst_.clipped_led, y, x)) add_full(y, x, &sums);
    }
    return sums;
  }

 private:
  bool confident(const Image1& map, int y, int x) const {
    return !map.empty() && map(y, x) >= kConfident;
  }

  void add_front(int y, int x, AllSums* sums) const {
    const Vec3 n = layers_.normals.specular(y, x);
    const float cosine = dot(n, layers_.geometry.to_projector(y, x));
    if (!(cosine > kRerenderMinCosine) || !confident(layers_.separation.confidence, y, x)) return;
    const float irradiance = cosine * layers_.geometry.projector_irradiance(y, x);
    const Vec3 albedo =
        layers_.separation.shallow_albedo(y, x) + layers_.separation.deep_albedo(y, x);
    const Vec3 half_diffuse = albedo * (0.5f * irradiance);
    if (!is_finite(half_diffuse)) return;
    sums->front_cross.add(half_diffuse, burst_.front.cross(y, x));
    if (!confident(layers_.specular.intensity_confidence, y, x)) return;
    sums->front_parallel.add(half_diffuse + layers_.specular.polarized_front(y, x),
                             burst_.front.parallel(y, x));
  }

  void add_full(int y, int x, AllSums* sums) const {
    if (!confident(layers_.albedo.confidence, y, x)) return;
    const float visible = layers_.normals.ambient_visibility(y, x);
    Vec3 half_diffuse;
    for (int c = 0; c < 3; ++c) {
      const Vec3 n = layers_.normals.diffuse[size_t(c)](y, x);
      if (!is_finite(n)) return;
      const float irradiance = leds_.at(n, layers_.geometry.position_mm(y, x))[c];
      half_diffuse[c] = 0.5f * layers_.albedo.total(y, x)[c] * visible * irradiance;
    }
    if (!is_finite(half_diffuse)) return;
    sums->full_cross.add(half_diffuse, burst_.full.cross(y, x));
    if (!confident(layers_.specular.intensity_confidence, y, x)) return;
    sums->full_parallel.add(half_diffuse + layers_.specular.polarized_full(y, x),
                            burst_.full.parallel(y, x));
  }

  const Burst& burst_;
  const FittedLayers& layers_;
  LedIrradiance leds_;
};

}  // namespace

RerenderResiduals rerender(const Burst& burst, const FittedLayers& layers) {
  const Rerenderer rerenderer(burst, layers);
  std::vector<AllSums> rows(static_cast<size_t>(burst.regions.rows));
  parallel_for(
      burst.regions.rows, [&](int y) { rows[size_t(y)] = rerenderer.row(y); }, 8);
  AllSums all;
  for (const AllSums& row : rows) all.add(row);
  return {all.front_parallel.relative(), all.front_cross.relative(), all.full_parallel.relative(),
          all.full_cross.relative(),     all.front_cross.off(),      all.front_parallel.off()};
}

}  // namespace lamella::fit
