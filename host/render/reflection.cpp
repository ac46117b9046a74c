#include "render/reflection.h"

#include <algorithm>

#include "model/single_scattering.h"
#include "model/torrance_sparrow.h"

namespace lamella::render {

namespace {

// g where layers.json has none: the middle of what was measured on faces (sec. 5).
constexpr float kUsualG = 0.66f;
// Of a clean, smooth-walled interface.
constexpr double kCleanIntensity = 0.25;
// Eq. 1 divides by n.v: at the silhouette a pixel is not all at the angle of its centre.
constexpr float kGrazing = 0.02f;

Vec3 global_g(const Subject& subject) {
  Vec3 g = Vec3::all(kUsualG);
  const auto& measured = subject.layers.single().g();
  for (int c = 0; c < std::min(3, measured.size()); ++c) g[c] = float(measured[c]);
  return g;
}

double median_intensity(const Subject& subject, int label) {
  std::vector<float> values;
  const LayerMaps& maps = subject.maps;
  if (maps.specular_intensity.empty()) return kCleanIntensity;
  for (int i = 0; i < maps.regions.rows; i += 3) {
    for (int j = 0; j < maps.regions.cols; j += 3) {
      const float c = maps.specular_intensity(i, j);
      if (maps.regions(i, j) == label && is_finite(c)) values.push_back(c);
    }
  }
  if (values.empty()) return kCleanIntensity;
  const auto middle = values.begin() + long(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Reflection::Reflection(const Subject& subject)
    : regions_(subject.region_names.size()), g_(global_g(subject)) {
  for (int label = 1; label < int(regions_.size()); ++label) {
    const v1::Region* fitted = subject.region(label);
    if (!fitted || fitted->specular().p_size() < 2) continue;
    const auto& s = fitted->specular();
    Region& region = regions_[label];
    region.lobe =
        model::LobeTable({s.theta().begin(), s.theta().end()}, {s.p().begin(), s.p().end()});
    region.transmittance = model::TransmittanceTable(region.lobe, median_intensity(subject, label));
    region.has_lobe = true;
  }
}

Vec3 Reflection::radiance(const SkinPoint& point, const Incident& incident) const {
  const Region& region = regions_[point.region];
  const Vec3 &n = point.normal, &v = point.to_camera, &l = incident.direction;
  const float n_l = dot(n, l), n_v = std::max(kGrazing, dot(n, v));
  if (n_l <= 0) return {0, 0, 0};
  const Vec3 h = unit(l + v);
  float surface = 0;
  if (region.has_lobe) {
    surface =
        point.intensity * model::lobe_times_cosine(region.lobe, dot(n, h), n_v, n_l, dot(v, h));
  }
  const float cos_l = model::refracted_cosine(n_l), cos_v = model::refracted_cosine(n_v);
  const float cosine = model::scattering_cosine(dot(l, v), n_l, n_v, cos_l, cos_v);
  const float shared =
      n_l * region.transmittance(n_l) * region.transmittance(n_v) / (cos_l + cos_v);
  Vec3 out;
  for (int c = 0; c < 3; ++c) {
    const float single = point.single_alpha[c] * model::henyey_greenstein(cosine, g_[c]) * shared;
    out[c] = kPi * incident.irradiance[c] * (surface + single);
  }
  return out;
}

Vec3 region_single_alpha(const Subject& subject, int label) {
  const v1::Region* fitted = subject.region(label);
  if (!fitted || fitted->single().amplitude_size() != 3) return {0, 0, 0};
  const Vec3 g = global_g(subject);
  Vec3 alpha;
  for (int c = 0; c < 3; ++c) {
    alpha[c] = float(model::alpha_from_amplitude(fitted->single().amplitude(c), g[c]));
  }
  return alpha;
}

}  // namespace lamella::render
