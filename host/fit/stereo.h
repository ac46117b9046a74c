// The right camera's word on what the left camera and the projector measured.
#pragma once

#include "fit/depth_map.h"

namespace lamella::fit {

// Left ray, right ray and column meet in one point. Scattering shifts the phase of a point on a
// curved surface, but by the same amount for both cameras: the pair that sees the same column is
// free of that error, and noise is less as the rays are further apart. Points through which the
// right camera sees something that lies behind are dropped. Those that it does not see are left to
// `left` alone.
Agreement refine_with_right(const Camera& left_camera, const Camera& right_camera,
                            const Camera& projector, const DepthMap& right, DepthMap* left);

// One camera's and the projector's word alone: sigma with the bias in it.
void believe_alone(DepthMap* depth);

}  // namespace lamella::fit
