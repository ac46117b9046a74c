// The subject lit and seen: surface and single scattering (S, keeps its polarization) and multiple
// scattering (D, does not), for any light of the rig. Everything is linear in the light.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/session.h"
#include "io/view.h"
#include "twin/diffusion.h"
#include "twin/lighting.h"
#include "twin/receivers.h"
#include "twin/surface_reflection.h"

namespace lamella::twin {

enum class Eye { kLeft, kRight };

// Radiance of a subject per receiver of a camera.
using Radiance = std::vector<Vec3>;

class Photographer {
 public:
  struct Options {
    std::string subject = "head";
    std::string skin = "layered";
    uint64_t seed = 1;
    double scale = 1.0;
    double noise = 1.0;   // times the sensor's
    int photons = 80000;  // per region and channel
    float spacing_mm = 0.4f;
  };
  explicit Photographer(const Options& options);

  // The same with the subject elsewhere, by a few millimetres: told in the subject's own frame, in
  // which cameras and projector go the other way. The LEDs are far away.
  Photographer moved(const Vec3& by_mm) const;

  // How far the subject moves, evenly, from a session's first photograph to its last: to the right
  // as the cameras see it, down and towards them.
  void set_drift(double mm);
  Vec3 drift_mm() const { return drift_mm_; }

  // Every LED shines by another gain than the session's calibration has it: of mean 1, normal with
  // this relative deviation.
  void set_led_spread(double share, uint64_t seed);
  const std::vector<float>& led_gains() const { return led_gains_; }

  const Session& rig() const { return rig_; }
  const Subject& subject() const { return body_->subject; }
  const std::array<Skin, kRegionCount>& skins() const { return body_->skins; }
  const SkinProfiles& profiles() const { return body_->profiles; }
  const Surface& surface() const { return body_->surface; }
  const Receivers& receivers(Eye eye) const { return eye == Eye::kLeft ? left_ : right_; }
  Receivers see(const Camera& camera) const;

  // Power on the surface, ready to scatter.
  PatchLight led_light(const std::vector<float>& levels) const;
  PatchLight projector_light(const Image3& emitted) const;
  PatchLight point_light(const PointLight& light, const Vec3& colour) const;
  PatchLight gathered(const std::vector<Vec3>& irradiance) const;  // per vertex

  // D of every light, modulated by the skin's own texture: result[light][receiver].
  std::vector<Radiance> depolarized(const Receivers& receivers,
                                    const std::vector<const PatchLight*>& lights) const;

  // S under LED levels; under a point with a colour; under the projector's image.
  Radiance polarized_leds(const Receivers& receivers, const std::vector<float>& levels) const;
  Radiance polarized_point(const Receivers& receivers, const PointLight& light,
                           const Vec3& colour) const;
  Radiance polarized_projector(const Receivers& receivers, const Image3& emitted) const;

  const PointLight& projector() const { return *projector_; }

  // Pattern light at a place, in the colours of the LEDs: emitted value only, no cosine.
  Vec3 pattern_at(const Image3& emitted, const Vec3& x_mm) const;

 private:
  // What is the subject's own, wherever it is.
  struct Body {
    explicit Body(const Options& options, const std::vector<Led>& leds);

    Subject subject;
    std::array<Skin, kRegionCount> skins;
    SkinProfiles profiles;
    Surface surface;
    LedVisibility visibility;
    Diffusion diffusion;
    std::vector<LobeLoss> loss;
    std::array<Vec3, kRegionCount> single_albedo;
  };

  static Photographer at_rest(const Options& options);
  Photographer(std::shared_ptr<const Body> body, Session rig, double projector_distance_mm);
  Vec3 keeps_polarization(const Receivers& r, size_t i, const Vec3& l) const;
  void find_pattern_places();

  std::shared_ptr<const Body> body_;
  Session rig_;
  double projector_distance_mm_;  // from the rig's origin, where its white is 1
  std::unique_ptr<PointLight> projector_;
  // Four places of every vertex's patch in projector pixels: what falls on the patch is their mean.
  std::vector<std::array<Vec2, 4>> pattern_places_;
  Receivers left_, right_;
  Vec3 drift_mm_{0, 0, 0};
  std::vector<float> led_gains_;  // empty: as calibrated
};

}  // namespace lamella::twin
