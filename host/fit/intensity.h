// Specular intensity c of every pixel, from both lights, and what the fitted skin then shows under
// each of them.
#pragma once

#include <vector>

#include "fit/led_response.h"
#include "fit/lobe_fit.h"

namespace lamella::fit {

// What eq. 1 with c = 1 and eq. 3 with amplitude 1 show per pixel; NaN where there is no pixel.
struct Responses {
  Image1 led_lobe, led_single;      // under GRADIENT_FULL, visibility considered
  Image1 front_lobe, front_single;  // under FRONT; 0 where the projector does not reach
  Image1 led_share;                 // of the light above the horizon, cosine weighted, that reaches
  Image1 front_slope;               // |d log(front_lobe) / d theta|, per radian
  Image1 led_slope;                 // about the same of led_lobe, as the normal turns from the eye
};

// `skins`, `fits`: by label - 1.
Responses skin_responses(const Burst& burst, const Geometry& geometry, const Normals& normals,
                         const LightVisibility& visibility, const std::vector<SkinModel>& skins);

struct IntensityMap {
  Image1 c;           // of eq. 1
  Image1 confidence;  // 0 to 1: 1/(1 + relative standard deviation)
  Image1 stddev;      // of the camera's noise alone; of the neighbours' spread where they stand in
};

// c from GRADIENT_FULL and FRONT less single scattering, each weighted by its noise and by how well
// its model is known; where neither says much, c of the neighbourhood, then of the region.
IntensityMap estimate_intensity(const Burst& burst, const Responses& responses,
                                const std::vector<RegionFit>& fits);

}  // namespace lamella::fit
