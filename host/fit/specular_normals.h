// Fine detail of the normals from the polarized gradients, which scattering does not blur.
#pragma once

#include "fit/burst.h"

namespace lamella::fit {

struct SurfaceView {
  const Image3& to_camera;    // v, unit
  const Image1& distance_mm;  // along the ray; NaN off the surface
  float px_mm;                // size of a pixel on the face
};

using SpecularMoments = cv::Vec4f;  // S, 2 S_a - S; mean of the channels

// Undefined where there is no surface (a distance of NaN); zero where clipped.
cv::Mat_<SpecularMoments> specular_moments(const Burst& burst, const Image1& distance_mm);

// `base` (unit) with the detail that r = 2 S_a/S - 1, n = normalise(r + v) shows beyond it. Alone
// the specular normal is noisy, and pulled off by single scattering, by the lobe's end at the
// horizon and by Fresnel: all of them slow, so that only what is finer than scattering's blur is
// taken, by Wiener's rule: as much of it as rises above the camera's noise.
Image3 add_specular_detail(const Burst& burst, cv::Mat_<SpecularMoments> moments,
                           const SurfaceView& view, const Image3& base);

}  // namespace lamella::fit
