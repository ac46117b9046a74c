// What one camera and the projector measure together: a distance along every pixel's ray.
#pragma once

#include "base/camera.h"
#include "fit/fringe_phase.h"

namespace lamella::fit {

// The right camera's word on what the left one and the projector measured; NaN without one.
struct Agreement {
  double share = std::numeric_limits<double>::quiet_NaN();     // of the points, that both agree on
  double apart_px = std::numeric_limits<double>::quiet_NaN();  // in its photograph, median, signed
};

struct DepthMap {
  Image1 distance_mm;   // along the ray; NaN where nothing was measured
  Image1 sigma_mm;      // one sigma, from the camera's noise
  Image1 u_px;          // projector column
  float px_mm = 1;      // size of a pixel on the face
  int penumbra_px = 3;  // beside a gap: scattered light alone is seen there; 0 of a mesh
  Image1 bias_mm = {};  // one sigma, from light that scattered on its way; of no mesh
  Agreement right = {};

  void forget(int y, int x) { distance_mm(y, x) = sigma_mm(y, x) = u_px(y, x) = kNaN; }
};

// Ray and sheet of light, pixel by pixel, then without what cannot be surface (a wrong turn of the
// phase leaves a pixel or a patch away from its neighbours), then averaged along the surface. The
// last pixels before a silhouette, where a surface falls steeply, stay.
DepthMap measure_depth(const Camera& camera, const Camera& projector,
                       const ProjectorColumns& columns);

// The pieces that are connected without a silhouette and have less than `least_px` pixels go.
void drop_islands(DepthMap* depth, int least_px);

}  // namespace lamella::fit
