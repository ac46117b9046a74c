#include "twin/photographer.h"

#include <algorithm>

#include "base/parallel.h"
#include "twin/patterns.h"
#include "twin/rig.h"

namespace lamella::twin {

namespace {

// Sessions of another skin than the usual say so in their subject.
std::string described(const Photographer::Options& options) {
  return options.skin == "layered" ? options.subject : options.subject + "-" + options.skin;
}

}  // namespace

Photographer::Photographer(const Options& options)
    : rig_(make_rig(described(options), options.scale, options.noise)),
      subject_(make_subject(options.subject, options.seed)),
      skins_(facial_skins(options.seed, skin_kind(options.skin))),
      profiles_(walk_skins(skins_, options.photons, options.seed)),
      surface_(make_surface(subject_, options.spacing_mm)) {
  visibility_ = std::make_unique<LedVisibility>(surface_, rig_.stage.leds());
  projector_ = std::make_unique<PointLight>(surface_, Vec3(rig_.projector.centre_mm()));
  find_pattern_places();
  diffusion_ = std::make_unique<Diffusion>(surface_, profiles_);
  for (size_t k = 0; k < skins_.size(); ++k) {
    loss_.emplace_back(skins_[k].roughness);
    for (int c = 0; c < 3; ++c) single_albedo_[k][c] = single_albedo(skins_[k], c);
  }
  left_ = see(rig_.left);
  right_ = see(*rig_.right);
}

Receivers Photographer::see(const Camera& camera) const {
  return see_subject(camera, surface_, subject_, skins_);
}

PatchLight Photographer::led_light(const std::vector<float>& levels) const {
  return gathered(led_irradiance(surface_, *visibility_, rig_.stage, levels));
}

Vec3 Photographer::pattern_at(const Image3& emitted, const Vec3& x_mm) const {
  return sample_pattern(emitted, rig_.projector.project(Vec3d(x_mm)));
}

void Photographer::find_pattern_places() {
  pattern_places_.resize(surface_.size());
  parallel_for(
      surface_.rows,
      [&](int row) {
        const int above = std::max(row - 1, 0), below = std::min(row + 1, surface_.rows - 1);
        for (int column = 0; column < surface_.columns; ++column) {
          const size_t i = size_t(surface_.at(row, column));
          if (projector_->vertex_irradiance()[i] <= 0.f) continue;
          const auto place = [&](int r, int c) {
            return surface_.position_mm[size_t(surface_.at(r, c))];
          };
          const Vec3 down = (place(below, column) - place(above, column)) * 0.125f;
          const Vec3 across = (place(row, column + 1) - place(row, column - 1)) * 0.125f;
          for (int k = 0; k < 4; ++k) {
            const Vec3 x = surface_.position_mm[i] + down * (k < 2 ? -1.f : 1.f) +
                           across * (k % 2 ? 1.f : -1.f);
            pattern_places_[i][size_t(k)] = Vec2(rig_.projector.project(Vec3d(x)));
          }
        }
      },
      8);
}

PatchLight Photographer::projector_light(const Image3& emitted) const {
  std::vector<Vec3> irradiance(surface_.size(), Vec3(0, 0, 0));
  parallel_for(
      int(surface_.size()),
      [&](int i) {
        const float e = projector_->vertex_irradiance()[size_t(i)];
        if (e <= 0.f) return;
        Vec3 sum(0, 0, 0);
        for (const Vec2& place : pattern_places_[size_t(i)]) sum += sample_pattern(emitted, place);
        irradiance[size_t(i)] = sum * (0.25f * e);
      },
      4096);
  return gathered(irradiance);
}

PatchLight Photographer::gathered(const std::vector<Vec3>& irradiance) const {
  return gather_light(diffusion_->tree(), irradiance);
}

PatchLight Photographer::point_light(const PointLight& light, const Vec3& colour) const {
  std::vector<Vec3> irradiance(surface_.size());
  for (size_t i = 0; i < irradiance.size(); ++i) {
    irradiance[i] = colour * light.vertex_irradiance()[i];
  }
  return gathered(irradiance);
}

std::vector<Radiance> Photographer::depolarized(
    const Receivers& receivers, const std::vector<const PatchLight*>& lights) const {
  std::vector<Radiance> radiance = diffusion_->scatter(receivers.targets, lights);
  for (Radiance& d : radiance) {
    for (size_t i = 0; i < d.size(); ++i) d[i] = d[i].mul(receivers.modulation[i]);
  }
  return radiance;
}

Vec3 Photographer::keeps_polarization(const Receivers& r, size_t i, const Vec3& l) const {
  const Vec3 n = r.shading_normal[i], v = r.to_camera[i];
  const float nl = dot(n, l), nv = std::max(dot(n, v), 0.02f);
  const RegionWeights& regions = r.targets.regions[i];
  float lobe = 0, transmitted = 0;
  Vec3 albedo(0, 0, 0);
  for (size_t k = 0; k < regions.size(); ++k) {
    if (regions[k] < 0.004f) continue;
    const float c = skins_[k].intensity;
    lobe += regions[k] * surface_lobe(n, l, v, skins_[k].roughness);
    transmitted += regions[k] * (1.f - std::min(1.f, c * loss_[k](nl))) *
                   (1.f - std::min(1.f, c * loss_[k](nv)));
    albedo += single_albedo_[k] * regions[k];
  }
  const Vec3 below = single_scattering(n, l, v, transmitted).mul(albedo);
  return (Vec3::all(r.intensity[i] * lobe) + below) * (kPi * nl);
}

Radiance Photographer::polarized_leds(const Receivers& r, const std::vector<float>& levels) const {
  Radiance s(r.size(), Vec3(0, 0, 0));
  parallel_for(
      int(r.size()),
      [&](int n) {
        const size_t i = size_t(n);
        const auto corners = visibility_->around(r.grid_row[i], r.grid_column[i]);
        for (size_t led = 0; led < levels.size(); ++led) {
          if (levels[led] <= 0.f) continue;
          const Vec3 l = rig_.stage.leds()[led].direction;
          if (dot(r.shading_normal[i], l) <= 0.f) continue;
          const float seen = corners.of(led);
          if (seen <= 0.f) continue;
          const Vec3 e =
              rig_.stage.irradiance(led, r.targets.position_mm[i]) * (levels[led] * seen);
          s[i] += keeps_polarization(r, i, l).mul(e);
        }
      },
      256);
  return s;
}

Radiance Photographer::polarized_point(const Receivers& r, const PointLight& light,
                                       const Vec3& colour) const {
  Radiance s(r.size(), Vec3(0, 0, 0));
  parallel_for(
      int(r.size()),
      [&](int n) {
        const size_t i = size_t(n);
        const Vec3 x = r.targets.position_mm[i], l = light.direction(x);
        if (dot(r.shading_normal[i], l) <= 0.f || !light.sees(x, r.normal[i])) return;
        s[i] = keeps_polarization(r, i, l).mul(colour) * light.strength(x);
      },
      256);
  return s;
}

Radiance Photographer::polarized_projector(const Receivers& r, const Image3& emitted) const {
  Radiance s = polarized_point(r, *projector_, {1, 1, 1});
  parallel_for(
      int(r.size()),
      [&](int i) {
        s[size_t(i)] = s[size_t(i)].mul(pattern_at(emitted, r.targets.position_mm[size_t(i)]));
      },
      1024);
  return s;
}

}  // namespace lamella::twin
