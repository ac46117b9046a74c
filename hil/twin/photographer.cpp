#include "twin/photographer.h"

#include <algorithm>

#include "base/parallel.h"
#include "twin/patterns.h"
#include "twin/random.h"
#include "twin/rig.h"

namespace lamella::twin {

namespace {

constexpr uint64_t kLedSpreadSeed = 0x1ed5;  // apart from the sensor's and the skin's
const Vec3 kDriftDirection = unit({0.7f, -0.6f, 0.4f});

// Sessions of another skin than the usual say so in their subject.
std::string described(const Photographer::Options& options) {
  return options.skin == "layered" ? options.subject : options.subject + "-" + options.skin;
}

}  // namespace

Photographer::Body::Body(const Options& options, const std::vector<Led>& leds)
    : subject(make_subject(options.subject, options.seed)),
      skins(facial_skins(options.seed, skin_kind(options.skin))),
      profiles(walk_skins(skins, options.photons, options.seed)),
      surface(make_surface(subject, options.spacing_mm)),
      visibility(surface, leds),
      diffusion(surface, profiles) {
  for (size_t k = 0; k < skins.size(); ++k) {
    loss.emplace_back(skins[k].roughness);
    for (int c = 0; c < 3; ++c) single_albedo[k][c] = twin::single_albedo(skins[k], c);
  }
}

Photographer::Photographer(std::shared_ptr<const Body> body, Session rig,
                           double projector_distance_mm)
    : body_(std::move(body)),
      rig_(std::move(rig)),
      projector_distance_mm_(projector_distance_mm),
      projector_(std::make_unique<PointLight>(surface(), Vec3(rig_.projector.centre_mm()),
                                              projector_distance_mm)) {
  find_pattern_places();
  left_ = see(rig_.left);
  right_ = see(*rig_.right);
}

Photographer Photographer::at_rest(const Options& options) {
  Session rig = make_rig(described(options), options.scale, options.noise);
  auto body = std::make_shared<const Body>(options, rig.stage.leds());
  const double distance_mm = cv::norm(rig.projector.centre_mm());
  return {std::move(body), std::move(rig), distance_mm};
}

Photographer::Photographer(const Options& options) : Photographer(at_rest(options)) {}

void Photographer::set_drift(double mm) { drift_mm_ = kDriftDirection * float(mm); }

void Photographer::set_led_spread(double share, uint64_t seed) {
  led_gains_.clear();
  if (!(share > 0)) return;
  Random random(mix_bits(seed + kLedSpreadSeed));
  float sum = 0;
  for (size_t i = 0; i < rig_.stage.leds().size(); ++i) {
    led_gains_.push_back(std::max(0.f, 1 + float(share) * random.normal()));
    sum += led_gains_.back() / float(rig_.stage.leds().size());
  }
  for (float& gain : led_gains_) gain /= sum;
}

Photographer Photographer::moved(const Vec3& by_mm) const {
  Session rig = rig_;
  for (Camera* camera : {&rig.left, &*rig.right, &rig.projector}) {
    camera->translation_mm += camera->cam_from_rig * Vec3d(by_mm);
  }
  Photographer there(body_, std::move(rig), projector_distance_mm_);
  there.led_gains_ = led_gains_;
  return there;
}

Receivers Photographer::see(const Camera& camera) const {
  return see_subject(camera, surface(), subject(), skins());
}

PatchLight Photographer::led_light(const std::vector<float>& levels) const {
  return gathered(led_irradiance(surface(), body_->visibility, rig_.stage, levels));
}

Vec3 Photographer::pattern_at(const Image3& emitted, const Vec3& x_mm) const {
  return sample_pattern(emitted, rig_.projector.project(Vec3d(x_mm)));
}

void Photographer::find_pattern_places() {
  const Surface& surface = body_->surface;
  pattern_places_.resize(surface.size());
  parallel_for(
      surface.rows,
      [&](int row) {
        const int above = std::max(row - 1, 0), below = std::min(row + 1, surface.rows - 1);
        for (int column = 0; column < surface.columns; ++column) {
          const size_t i = size_t(surface.at(row, column));
          if (projector_->vertex_irradiance()[i] <= 0.f) continue;
          const auto place = [&](int r, int c) {
            return surface.position_mm[size_t(surface.at(r, c))];
          };
          const Vec3 down = (place(below, column) - place(above, column)) * 0.125f;
          const Vec3 across = (place(row, column + 1) - place(row, column - 1)) * 0.125f;
          for (int k = 0; k < 4; ++k) {
            const Vec3 x = surface.position_mm[i] + down * (k < 2 ? -1.f : 1.f) +
                           across * (k % 2 ? 1.f : -1.f);
            pattern_places_[i][size_t(k)] = Vec2(rig_.projector.project(Vec3d(x)));
          }
        }
      },
      8);
}

PatchLight Photographer::projector_light(const Image3& emitted) const {
  const Surface& surface = body_->surface;
  std::vector<Vec3> irradiance(surface.size(), Vec3(0, 0, 0));
  parallel_for(
      int(surface.size()),
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
  return gather_light(body_->diffusion.tree(), irradiance);
}

PatchLight Photographer::point_light(const PointLight& light, const Vec3& colour) const {
  std::vector<Vec3> irradiance(surface().size());
  for (size_t i = 0; i < irradiance.size(); ++i) {
    irradiance[i] = colour * light.vertex_irradiance()[i];
  }
  return gathered(irradiance);
}

std::vector<Radiance> Photographer::depolarized(
    const Receivers& receivers, const std::vector<const PatchLight*>& lights) const {
  std::vector<Radiance> radiance = body_->diffusion.scatter(receivers.targets, lights);
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
    const float c = skins()[k].intensity;
    lobe += regions[k] * surface_lobe(n, l, v, skins()[k].roughness);
    transmitted += regions[k] * (1.f - std::min(1.f, c * body_->loss[k](nl))) *
                   (1.f - std::min(1.f, c * body_->loss[k](nv)));
    albedo += body_->single_albedo[k] * regions[k];
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
        const auto corners = body_->visibility.around(r.grid_row[i], r.grid_column[i]);
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
