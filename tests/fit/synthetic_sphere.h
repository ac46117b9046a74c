// A sphere of known skin, photographed by the equations themselves: what the fit should give back.
#pragma once

#include <random>

#include "fit/normals.h"
#include "model/single_scattering.h"
#include "model/torrance_sparrow.h"

namespace lamella::fit {

struct SyntheticSkin {
  double gaussian_m = 0.3;
  float c = 0.3f;
  std::array<double, 3> amplitude{0.067, 0.063, 0.053};
};

struct SyntheticSphere {
  Session session;
  Burst burst;
  Geometry geometry;
  Normals normals;
};

inline model::LobeTable gaussian_lobe(double m) {
  std::vector<double> theta, p;
  for (int i = 0; i <= 180; ++i) {
    theta.push_back(double(kPi) / 2 * i / 180);
    p.push_back(std::exp(-theta.back() * theta.back() / (m * m)));
  }
  return {theta, p};
}

inline Camera camera_at(const Vec3d& centre_mm, int size) {
  Camera camera;
  camera.width = camera.height = size;
  camera.fx = camera.fy = size * 5.0;
  camera.cx = camera.cy = (size - 1) / 2.0;
  const Vec3d z = centre_mm * (-1 / cv::norm(centre_mm)), x = Vec3d(0, 1, 0).cross(-z);
  const Vec3d right = x * (1 / cv::norm(x)), down = z.cross(right);
  camera.cam_from_rig =
      Mat33d(right[0], right[1], right[2], down[0], down[1], down[2], z[0], z[1], z[2]);
  camera.translation_mm = -(camera.cam_from_rig * centre_mm);
  camera.saturation = 1;
  camera.full_well_electrons = 30000;
  return camera;
}

// An even sphere of LEDs, without those around the cameras.
inline LightStage even_stage() {
  std::vector<Led> leds;
  for (int i = 0; i < 150; ++i) {
    const double z = 1 - 2 * (i + 0.5) / 150, r = std::sqrt(1 - z * z), azimuth = 2.399963 * i;
    const Vec3 direction(float(r * std::cos(azimuth)), float(r * std::sin(azimuth)), float(z));
    if (z < 0.96) leds.push_back({direction, 0, {1, 1, 1}});
  }
  return LightStage(leds);
}

class SpherePhotographer {
 public:
  // `noise`: times the variance of a good camera.
  explicit SpherePhotographer(double noise = 1) : noise_(noise) {}

  // `skins`: by label - 1; `label(x, y)` with x, y from -1 to 1 across the sphere, 0 nowhere.
  template <class Label>
  SyntheticSphere photograph(const std::vector<SyntheticSkin>& skins, const Label& label,
                             bool noisy) {
    SyntheticSphere s;
    set_up(int(skins.size()), &s);
    for (const SyntheticSkin& skin : skins) {
      lobes_.push_back(gaussian_lobe(skin.gaussian_m));
      transmittances_.emplace_back(lobes_.back(), skin.c);
    }
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        if (!place(y, x, &s)) continue;
        const Vec3 p = s.geometry.position_mm(y, x) * (1.f / kRadiusMm);
        const int region = label(p[0], p[1]);
        s.burst.regions(y, x) = uint8_t(region);
        if (region > 0) expose(y, x, skins[size_t(region - 1)], noisy, &s);
      }
    }
    return s;
  }

  static constexpr int kSize = 240;
  static constexpr float kRadiusMm = 80.f;
  static constexpr float kAlbedo = 0.4f;

 private:
  void set_up(int regions, SyntheticSphere* s) {
    s->session.stage = even_stage();
    s->session.left = camera_at({170, 0, 985}, kSize);
    s->session.projector = camera_at({0, 0, 1000}, kSize);
    s->burst.session = &s->session;
    s->burst.led_noise = s->burst.projector_noise = {noise_ * 0.0004 * 0.0004, noise_ / 30000};
    s->burst.led_parallel_noise = s->burst.front_parallel_noise = s->burst.led_noise;
    const cv::Size size(kSize, kSize);
    const Vec3 nowhere(kNaN, kNaN, kNaN);
    s->burst.regions = Labels(size, 0);
    s->burst.has_given_regions = true;
    for (int i = 0; i <= regions; ++i)
      s->burst.region_names.push_back("region" + std::to_string(i));
    for (AnalyserPair* pair : {&s->burst.full, &s->burst.front}) {
      pair->parallel = Image3(size, Vec3(0, 0, 0));
      pair->cross = Image3(size, Vec3(0, 0, 0));
    }
    s->burst.clipped_led = Mask(size, 0);
    s->burst.clipped_projector = Mask(size, 0);
    s->geometry.position_mm = Image3(size, nowhere);
    s->geometry.to_camera = Image3(size, nowhere);
    s->geometry.to_projector = Image3(size, nowhere);
    s->geometry.projector_irradiance = Image1(size, kNaN);
    s->normals.specular = Image3(size, nowhere);
    for (Image3& diffuse : s->normals.diffuse) diffuse = s->normals.specular;
    s->normals.ambient_visibility = Image1(size, 1.f);
  }

  // False where the pixel's ray misses the sphere.
  static bool place(int y, int x, SyntheticSphere* s) {
    const Vec3d o = s->session.left.centre_mm(), d = s->session.left.ray(x, y);
    const double b = o.dot(d), c = o.dot(o) - double(kRadiusMm) * double(kRadiusMm);
    if (b * b < c) return false;
    const Vec3 p(o + d * (-b - std::sqrt(b * b - c)));
    s->geometry.position_mm(y, x) = p;
    s->geometry.to_camera(y, x) = unit(Vec3(o) - p);
    s->geometry.to_projector(y, x) = unit(Vec3(s->session.projector.centre_mm()) - p);
    s->geometry.projector_irradiance(y, x) = projector_irradiance(s->session.projector, p);
    s->normals.specular(y, x) = unit(p);
    return true;
  }

  // S of one light, and D/2.
  void add_light(const Vec3& l, float radiance, const SyntheticSkin& skin, size_t region,
                 const Vec3& n, const Vec3& v, Vec3* polarized, Vec3* half_diffuse) const {
    const float n_l = dot(n, l);
    if (n_l <= 0) return;
    const float lobe = skin.c * model::torrance_sparrow(lobes_[region], n, l, v);
    const float single = model::single_scattering(transmittances_[region], 0.65f, n, l, v);
    for (int k = 0; k < 3; ++k) {
      (*polarized)[k] += kPi * radiance * n_l * (lobe + float(skin.amplitude[size_t(k)]) * single);
      (*half_diffuse)[k] += 0.5f * kAlbedo * radiance * n_l;
    }
  }

  void expose(int y, int x, const SyntheticSkin& skin, bool noisy, SyntheticSphere* s) {
    const size_t region = size_t(s->burst.regions(y, x) - 1);
    const Vec3 n = s->normals.specular(y, x), v = s->geometry.to_camera(y, x);
    Vec3 front(0, 0, 0), front_diffuse(0, 0, 0), full(0, 0, 0), full_diffuse(0, 0, 0);
    add_light(s->geometry.to_projector(y, x), s->geometry.projector_irradiance(y, x), skin, region,
              n, v, &front, &front_diffuse);
    const LightStage& stage = s->session.stage;
    for (size_t i = 0; i < stage.leds().size(); ++i) {
      add_light(stage.leds()[i].direction, mean(stage.irradiance(i, {0, 0, 0})), skin, region, n, v,
                &full, &full_diffuse);
    }
    const NoiseModel& noise = s->burst.led_noise;
    s->burst.front.parallel(y, x) = sample(front + front_diffuse, noise, noisy);
    s->burst.front.cross(y, x) = sample(front_diffuse, noise, noisy);
    s->burst.full.parallel(y, x) = sample(full + full_diffuse, noise, noisy);
    s->burst.full.cross(y, x) = sample(full_diffuse, noise, noisy);
  }

  Vec3 sample(Vec3 radiance, const NoiseModel& noise, bool noisy) {
    if (!noisy) return radiance;
    for (int c = 0; c < 3; ++c) {
      radiance[c] += std::sqrt(noise.variance(radiance[c])) * normal_(random_);
    }
    return radiance;
  }

  double noise_;
  std::vector<model::LobeTable> lobes_;
  std::vector<model::TransmittanceTable> transmittances_;
  std::mt19937 random_{7};
  std::normal_distribution<float> normal_;
};

// What hides the lights from every sixth pixel of a surface.
inline Surroundings surroundings_of(const Image3& position_mm, const Image3& normal,
                                    const LightStage& stage) {
  Surroundings around = place_nodes(position_mm, stage);
  look_around(position_mm, normal, stage, {0, 0, 1000}, &around);
  return around;
}

// Burst holds a pointer to its session: set again wherever the sphere has come to rest.
inline void settle(SyntheticSphere* sphere) { sphere->burst.session = &sphere->session; }

}  // namespace lamella::fit
