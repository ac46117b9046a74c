// What an unshadowed Lambertian surface receives from the LEDs that are really there.
#pragma once

#include <vector>

#include "base/light_stage.h"

namespace lamella::fit {

// The sum over LEDs of irradiance x max(0, n.l), tabulated over the normal (octahedral map). Where
// LEDs have a distance, at the eight corners of the box that the subject fills.
class LedIrradiance {
 public:
  // `low_mm`, `high_mm`: corners of that box. `cells`: a side of the map, at least 2.
  LedIrradiance(const LightStage& stage, const Vec3& low_mm, const Vec3& high_mm, int cells);

  // Radiance (rgb) of white with unit normal `n` at `x_mm` under every LED at 1.
  Vec3 at(const Vec3& n, const Vec3& x_mm) const;

 private:
  Vec3 look_up(size_t table, const Vec3& n) const;

  Vec3 low_mm_, size_mm_;
  int cells_;
  std::vector<std::vector<Vec3>> tables_;  // one, or eight: x fastest
};

// For all of the measured surface (NaN where there is none).
LedIrradiance led_irradiance_over(const LightStage& stage, const Image3& position_mm, int cells);

}  // namespace lamella::fit
