// Where a face tells of its LEDs: open, measured places that look at the camera.
#pragma once

#include <vector>

#include "fit/geometry.h"
#include "fit/led_gains.h"
#include "fit/occlusion.h"

namespace lamella::fit {

// One a node, of the green channel, with shadows and bounces as `occlusion` has them.
std::vector<LedWitness> led_witnesses(const Burst& burst, const Geometry& geometry,
                                      const Surroundings& around,
                                      const std::vector<OcclusionAtNode>& occlusion,
                                      const cv::Mat_<DiffuseMoments>& moments);

}  // namespace lamella::fit
