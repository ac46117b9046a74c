// The only validation that a real face has: FRONT and GRADIENT_FULL drawn again from the fitted
// layers, through both analysers, against the photographs.
#pragma once

#include "fit/scattering.h"
#include "fit/specular.h"

namespace lamella::fit {

struct FittedLayers {
  const Geometry& geometry;
  const Normals& normals;
  const SpecularFit& specular;
  const Separation& separation;
  const Albedo& albedo;
};

// Root mean square of re-rendered minus photographed, over that of the photographed, all channels,
// where the maps are confident and the photograph is not clipped. NaN where no such pixel is.
struct RerenderResiduals {
  double front_parallel = 0, front_cross = 0, full_parallel = 0, full_cross = 0;
  // Of all the light of FRONT, per channel: re-rendered over photographed, less 1.
  std::array<double, 3> front_cross_off{}, front_parallel_off{};
};

// S as the fit predicts it; D of FRONT from shallow and deep albedo and the projector's irradiance,
// D of GRADIENT_FULL from total albedo, the LEDs' irradiance on the diffuse normals and the share
// of it that reaches the pixel. Light that bounces from skin to skin is not drawn.
RerenderResiduals rerender(const Burst& burst, const FittedLayers& layers);

}  // namespace lamella::fit
