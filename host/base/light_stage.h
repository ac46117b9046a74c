// The sphere of LEDs and the projector, in the radiometric units of a session: a white Lambertian
// surface at the origin has radiance 1 facing +Z under every LED at 1.0, and radiance 1 facing the
// projector under its all-white pattern.
#pragma once

#include <vector>

#include "base/camera.h"

namespace lamella {

struct Led {
  Vec3 direction;           // rig frame, unit, from the origin towards the LED
  float distance_mm = 0;    // 0: far away
  Vec3 intensity{1, 1, 1};  // rgb, relative
};

class LightStage {
 public:
  LightStage() = default;
  // Throws nothing: an empty stage lights nothing.
  explicit LightStage(std::vector<Led> leds);

  const std::vector<Led>& leds() const { return leds_; }

  // Radiance (rgb) that a white Lambertian surface at `x_mm`, facing LED `i` squarely, shows under
  // that LED alone at level 1: LED strength in session units, with 1/r^2 where a distance is given.
  Vec3 irradiance(size_t i, const Vec3& x_mm) const;

  // Unit direction from `x_mm` towards LED `i`.
  Vec3 direction_from(size_t i, const Vec3& x_mm) const;

 private:
  std::vector<Led> leds_;
  Vec3 unit_irradiance_{0, 0, 0};  // per channel: 1 / sum_i intensity_i max(0, w_i.z)
};

// The level of an LED in direction w under the gradient of axis a (0, 1, 2): (1 + w.a)/2.
inline float gradient_level(const Vec3& w, int axis) { return 0.5f * (1.f + w[axis]); }

// Radiance of a white Lambertian surface at `x_mm` facing the projector, white pattern, 1 at the
// origin; falls with the squared distance from the projector.
float projector_irradiance(const Camera& projector, const Vec3& x_mm);

}  // namespace lamella
