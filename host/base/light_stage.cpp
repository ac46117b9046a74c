#include "base/light_stage.h"

#include <algorithm>

namespace lamella {

LightStage::LightStage(std::vector<Led> leds) : leds_(std::move(leds)) {
  Vec3 sum(0, 0, 0);
  for (const Led& led : leds_) sum += led.intensity * std::max(0.f, led.direction[2]);
  for (int c = 0; c < 3; ++c) unit_irradiance_[c] = sum[c] > 0 ? 1.f / sum[c] : 0.f;
}

Vec3 LightStage::irradiance(size_t i, const Vec3& x_mm) const {
  const Led& led = leds_[i];
  Vec3 e = led.intensity.mul(unit_irradiance_);
  if (led.distance_mm > 0) {
    const Vec3 to_led = led.direction * led.distance_mm - x_mm;
    e *= led.distance_mm * led.distance_mm / dot(to_led, to_led);
  }
  return e;
}

Vec3 LightStage::direction_from(size_t i, const Vec3& x_mm) const {
  const Led& led = leds_[i];
  if (led.distance_mm <= 0) return led.direction;
  return unit(led.direction * led.distance_mm - x_mm);
}

float projector_irradiance(const Camera& projector, const Vec3& x_mm) {
  const Vec3 centre = projector.centre_mm();
  const Vec3 to_projector = centre - x_mm;
  return dot(centre, centre) / dot(to_projector, to_projector);
}

}  // namespace lamella
