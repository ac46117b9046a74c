// The whole diffuse reflectance of a pixel, two ways: under the LEDs, where almost nothing depends
// on the normal but occlusion does, and under the projector, the other way round.
#pragma once

#include "fit/led_irradiance.h"
#include "fit/normals.h"

namespace lamella::fit {

struct TotalAtPixel {
  Vec3 albedo;
  float sigma;          // relative, of what is not known of the light
  Vec3 noise_variance;  // relative, of the camera's noise alone
};

class DiffuseTotal {
 public:
  DiffuseTotal(const Burst& burst, const Geometry& geometry, const Normals& normals);

  // 2 GRADIENT_FULL cross over the light of the LEDs that reaches the pixel.
  TotalAtPixel from_leds(int y, int x) const;

  // 2 (FRONT - BLACK)/((1 - b) x irradiance x n.l).
  TotalAtPixel from_projector(int y, int x) const;

  // Their mean by inverse variance, of logarithms: at grazing light one of them may be far off.
  TotalAtPixel from_both(int y, int x) const;

 private:
  Vec3 normal(int y, int x) const;
  void find_ceilings();
  void limit(int y, int x, TotalAtPixel* total) const;

  const Burst& burst_;
  const Geometry& geometry_;
  const Normals& normals_;
  LedIrradiance leds_;
  std::vector<Vec3> ceiling_;  // by label: brighter skin than this is a wrong irradiance
};

}  // namespace lamella::fit
