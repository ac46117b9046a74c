#include "twin/truth_maps.h"

#include <algorithm>

#include "base/parallel.h"
#include "twin/patterns.h"

namespace lamella::twin {

namespace {

constexpr int kShifts = 16;            // of the stripes over one period; even
constexpr float kLeastCosine = 0.08f;  // flatter light says nothing of the skin

// Writes value(i) into the labelled pixels of the left camera, NaN elsewhere.
template <class Pixel, class Value>
cv::Mat_<Pixel> labelled_map(const Receivers& r, const Pixel& nothing, const Value& value) {
  cv::Mat_<Pixel> map(r.height, r.width, nothing);
  parallel_for(
      int(r.size()),
      [&](int n) {
        const size_t i = size_t(n);
        if (r.label[i]) map(r.pixel[i] / r.width, r.pixel[i] % r.width) = value(i);
      },
      1024);
  return map;
}

template <class Value>
Image3 map3(const Receivers& r, const Value& value) {
  return labelled_map<Vec3>(r, Vec3::all(kNaN), value);
}

// Mean over the regions at a receiver of a figure per region and channel.
template <class Figure>
Vec3 blended(const Receivers& r, size_t i, const Figure& figure) {
  Vec3 sum(0, 0, 0);
  for (size_t k = 0; k < kRegionCount; ++k) {
    const float w = r.targets.regions[i][k];
    if (w <= 0.f) continue;
    for (int c = 0; c < 3; ++c) sum[c] += w * float(figure(k, size_t(c)));
  }
  return sum;
}

// ---- diffuse normals ----

// Full light and the three gradients on an open white surface with this normal, and their
// derivatives by the normal.
struct OpenLight {
  std::array<float, 4> value{};
  std::array<Vec3, 4> slope{};
};

OpenLight open_light(const LightStage& stage, const Vec3& n) {
  OpenLight light;
  for (size_t i = 0; i < stage.leds().size(); ++i) {
    const Vec3 w = stage.leds()[i].direction;
    const float cosine = dot(w, n);
    if (cosine <= 0.f) continue;
    const float e = stage.irradiance(i, {0, 0, 0})[0];
    for (size_t a = 0; a < 4; ++a) {
      const float level = a == 0 ? e : e * gradient_level(w, int(a) - 1);
      light.value[a] += level * cosine;
      light.slope[a] += w * level;
    }
  }
  return light;
}

// The normal under which an open surface shows these ratios of gradient to full light.
Vec3 normal_of_ratios(const LightStage& stage, const Vec3& ratios, Vec3 n) {
  for (int step = 0; step < 4; ++step) {
    const OpenLight at = open_light(stage, n);
    const Vec3 side = std::abs(n[1]) < 0.9f ? Vec3(0, 1, 0) : Vec3(1, 0, 0);
    const Vec3 t = unit(cross(side, n)), b = cross(n, t);
    float tt = 0, tb = 0, bb = 0, gt = 0, gb = 0;
    for (size_t a = 0; a < 3; ++a) {
      const float ratio = at.value[a + 1] / at.value[0];
      const Vec3 slope = (at.slope[a + 1] - at.slope[0] * ratio) * (1.f / at.value[0]);
      const float st = dot(slope, t), sb = dot(slope, b), f = ratio - ratios[int(a)];
      tt += st * st, tb += st * sb, bb += sb * sb, gt += st * f, gb += sb * f;
    }
    const float det = tt * bb - tb * tb;
    if (!(det > 1e-12f)) break;
    n = unit(n - t * ((bb * gt - tb * gb) / det) - b * ((tt * gb - tb * gt) / det));
  }
  return n;
}

std::vector<Radiance> open_gradients(const Photographer& photographer) {
  const Surface& surface = photographer.surface();
  std::array<std::vector<Vec3>, 4> irradiance;
  for (auto& e : irradiance) e.resize(surface.size());
  parallel_for(
      int(surface.size()),
      [&](int i) {
        const OpenLight light =
            open_light(photographer.rig().stage, surface.shading_normal[size_t(i)]);
        for (size_t a = 0; a < 4; ++a) irradiance[a][size_t(i)] = Vec3::all(light.value[a]);
      },
      1024);
  std::vector<PatchLight> lights;
  std::vector<const PatchLight*> pointers;
  for (const auto& e : irradiance) lights.push_back(photographer.gathered(e));
  for (const PatchLight& light : lights) pointers.push_back(&light);
  return photographer.depolarized(photographer.receivers(Eye::kLeft), pointers);
}

void add_diffuse_normals(const Photographer& photographer, LayerMaps* maps) {
  const Receivers& r = photographer.receivers(Eye::kLeft);
  const std::vector<Radiance> d = open_gradients(photographer);
  for (int c = 0; c < 3; ++c) {
    maps->normal_diffuse[size_t(c)] = map3(r, [&](size_t i) {
      const float full = d[0][i][c];
      const Vec3 ratios(d[1][i][c] / full, d[2][i][c] / full, d[3][i][c] / full);
      return normal_of_ratios(photographer.rig().stage, ratios, r.normal[i]);
    });
  }
}

// ---- shallow and deep ----

// Largest value of a periodic curve through samples: the parabola through the highest three.
float periodic_peak(const float* samples, int count) {
  const int k = int(std::max_element(samples, samples + count) - samples);
  const float a = samples[(k + count - 1) % count], b = samples[k], c = samples[(k + 1) % count];
  const float bend = a - 2.f * b + c;
  return bend < 0.f ? b - (a - c) * (a - c) / (8.f * bend) : b;
}

// Pattern light alone (no black level) of the stripes over half a period, and of white.
std::vector<Radiance> stripe_sweep(const Photographer& photographer) {
  const Session& rig = photographer.rig();
  std::vector<PatchLight> lights;
  const auto add = [&](const Image3& pattern) {
    const Image3 light =
        (emitted(pattern) - cv::Scalar::all(kProjectorBlack)) * (1.0 / (1.0 - kProjectorBlack));
    lights.push_back(photographer.projector_light(light));
  };
  for (int k = 0; k < kShifts / 2; ++k) {
    add(stripe_pattern(rig, rig.patterns.stripe_period_px * k / kShifts));
  }
  add(even_pattern(rig, 1.f));
  std::vector<const PatchLight*> pointers;
  for (const PatchLight& light : lights) pointers.push_back(&light);
  return photographer.depolarized(photographer.receivers(Eye::kLeft), pointers);
}

// Irradiance of the white pattern at a receiver (without 1 - b); 0 where it does not reach.
float pattern_irradiance(const Photographer& photographer, const Receivers& r, size_t i) {
  const Vec3 x = r.targets.position_mm[i];
  const PointLight& light = photographer.projector();
  const float cosine = dot(r.shading_normal[i], light.direction(x));
  if (cosine < kLeastCosine || !light.sees(x, r.normal[i])) return 0.f;
  return cosine * light.strength(x);
}

void add_shallow_and_deep(const Photographer& photographer, LayerMaps* maps) {
  const Receivers& r = photographer.receivers(Eye::kLeft);
  const std::vector<Radiance> d = stripe_sweep(photographer);
  const auto separate = [&](size_t i, Vec3* shallow, Vec3* deep) {
    const float e = pattern_irradiance(photographer, r, i);
    if (e <= 0.f) return;
    for (int c = 0; c < 3; ++c) {
      // The second half of the period shows what white lacks of the first.
      float samples[kShifts], lacking[kShifts];
      const float white = d[kShifts / 2][i][c];
      for (int k = 0; k < kShifts / 2; ++k) {
        samples[k] = d[size_t(k)][i][c];
        samples[k + kShifts / 2] = white - samples[k];
      }
      for (int k = 0; k < kShifts; ++k) lacking[k] = -samples[k];
      const float highest = periodic_peak(samples, kShifts);
      const float lowest = -periodic_peak(lacking, kShifts);
      (*shallow)[c] = (highest - lowest) / e;
      (*deep)[c] = 2.f * lowest / e;
    }
  };
  maps->shallow_albedo = map3(r, [&](size_t i) {
    Vec3 shallow = Vec3::all(kNaN), deep = shallow;
    separate(i, &shallow, &deep);
    return shallow;
  });
  maps->deep_albedo = map3(r, [&](size_t i) {
    Vec3 shallow = Vec3::all(kNaN), deep = shallow;
    separate(i, &shallow, &deep);
    return deep;
  });
  const Image3& deep = maps->deep_albedo;
  maps->deep_alpha = map3(r, [&](size_t i) {
    const Vec3 a = deep(r.pixel[i] / r.width, r.pixel[i] % r.width);
    return Vec3(float(alpha_of_reflectance(a[0])), float(alpha_of_reflectance(a[1])),
                float(alpha_of_reflectance(a[2])));
  });
}

}  // namespace

std::array<RegionTruth, kRegionCount> region_truth(const SkinProfiles& profiles) {
  std::array<RegionTruth, kRegionCount> truth;
  parallel_for(kRegionCount * 3, [&](int i) {
    truth[size_t(i / 3)].dipole[size_t(i % 3)] =
        nearest_dipole(profiles[size_t(i / 3)][size_t(i % 3)]);
  });
  return truth;
}

Labels truth_labels(const Photographer& photographer) {
  const Receivers& r = photographer.receivers(Eye::kLeft);
  return labelled_map<uint8_t>(r, 0, [&](size_t i) { return r.label[i]; });
}

TruthMaps truth_maps(const Photographer& photographer,
                     const std::array<RegionTruth, kRegionCount>& regions) {
  const Receivers& r = photographer.receivers(Eye::kLeft);
  const SkinProfiles& profiles = photographer.profiles();
  TruthMaps truth;
  LayerMaps& maps = truth.maps;
  maps.regions = truth_labels(photographer);
  maps.position_mm = map3(r, [&](size_t i) { return r.targets.position_mm[i]; });
  maps.normal_specular = map3(r, [&](size_t i) { return r.shading_normal[i]; });
  maps.specular_intensity = labelled_map<float>(r, kNaN, [&](size_t i) { return r.intensity[i]; });
  const auto figure_map = [&](bool modulated, const auto& figure) {
    return map3(r, [&](size_t i) {
      const Vec3 value = blended(r, i, figure);
      return modulated ? value.mul(r.modulation[i]) : value;
    });
  };
  maps.single_albedo = figure_map(
      false, [&](size_t k, size_t c) { return single_albedo(photographer.skins()[k], int(c)); });
  maps.total_albedo = figure_map(true, [&](size_t k, size_t c) { return profiles[k][c].total(); });
  maps.deep_ld_mm =
      figure_map(false, [&](size_t k, size_t c) { return regions[k].dipole[c].ld_mm; });
  truth.shallow_physical =
      figure_map(true, [&](size_t k, size_t c) { return profiles[k][c].shallow_total; });
  truth.deep_physical =
      figure_map(true, [&](size_t k, size_t c) { return profiles[k][c].deep_total; });
  add_shallow_and_deep(photographer, &maps);
  add_diffuse_normals(photographer, &maps);
  return truth;
}

}  // namespace lamella::twin
