// The diffuse gradients as moments of the light that each pixel sends back, averaged along the
// surface.
#pragma once

#include "fit/burst.h"
#include "fit/occlusion.h"

namespace lamella::fit {

// Undefined where there is no surface (a distance of NaN). Averaged over less than light scatters;
// where the camera's noise is strong, what is finer than some millimetres is kept only as far as it
// rises above the noise (Wiener's rule).
// Lets go of the gradients of `burst` once they are read.
cv::Mat_<DiffuseMoments> diffuse_moments(Burst* burst, const Image1& distance_mm, float px_mm);

}  // namespace lamella::fit
