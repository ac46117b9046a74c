// Light that reaches the surface: the LED sphere, the projector, a point, with shadows.
#pragma once

#include <vector>

#include "io/session.h"
#include "twin/receivers.h"
#include "twin/surface.h"

namespace lamella::twin {

// Which LEDs each place of the surface sees, on every kStride-th vertex of the grid.
class LedVisibility {
 public:
  static constexpr int kStride = 4;

  LedVisibility(const Surface& surface, const std::vector<Led>& leds);

  // Share of LED `led` that the place sees, 0 to 1, between vertices.
  struct Corners {
    const uint8_t* row[4];  // of the four vertices around
    float weight[4];
    float of(size_t led) const {
      return (row[0][led] * weight[0] + row[1][led] * weight[1] + row[2][led] * weight[2] +
              row[3][led] * weight[3]) *
             (1.f / 255.f);
    }
  };
  Corners around(float grid_row, float grid_column) const;

  // Sum over the LEDs above the horizon and in sight of level * direction at every coarse vertex;
  // the irradiance of a nearby normal is its product with that.
  std::vector<Vec3> net_light(const std::vector<float>& levels, const LightStage& stage) const;

  // Values at coarse vertices to a place between them.
  Vec3 interpolate(const std::vector<Vec3>& coarse, float grid_row, float grid_column) const;

 private:
  struct Cell {
    int corner[4];
    float weight[4];
  };
  Cell cell(float grid_row, float grid_column) const;

  const Surface& surface_;
  size_t led_count_;
  int rows_, columns_;
  std::vector<uint8_t> seen_;  // [vertex][led]
};

// Irradiance per vertex (white Lambertian radiance, session units) under LED levels.
std::vector<Vec3> led_irradiance(const Surface& surface, const LedVisibility& visibility,
                                 const LightStage& stage, const std::vector<float>& levels);

// A light at one place: the projector, or a bare point.
class PointLight {
 public:
  // At `position_mm`; a white surface that faces it has radiance 1 from as far as the origin is.
  PointLight(const Surface& surface, const Vec3& position_mm)
      : PointLight(surface, position_mm, double(length(position_mm))) {}

  // The same with the distance from which that radiance is 1.
  PointLight(const Surface& surface, const Vec3& position_mm, double distance_of_one_mm);

  // Unit direction from `x_mm` to the light, and what a white surface there shows facing it.
  Vec3 direction(const Vec3& x_mm) const { return unit(position_mm_ - x_mm); }
  float strength(const Vec3& x_mm) const;

  // Is nothing between the light and a place of the surface with this normal?
  bool sees(const Vec3& x_mm, const Vec3& normal) const;

  // Irradiance of every vertex (cosine, distance, shadow), without a pattern.
  const std::vector<float>& vertex_irradiance() const { return vertex_irradiance_; }

 private:
  const Surface& surface_;
  Vec3 position_mm_;
  float distance_of_one_mm_;
  std::vector<float> vertex_irradiance_;
};

}  // namespace lamella::twin
