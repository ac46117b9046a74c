// How shadows and light that bounces from face to face bend the mean direction of the diffuse
// gradients, node by node, and the correction that undoes it.
#pragma once

#include <array>
#include <vector>

#include "fit/gradient_inversion.h"
#include "fit/surroundings.h"

namespace lamella::fit {

// Per channel: C and 2 G_a - C of the depolarized light D, a = x, y, z.
using DiffuseMoments = cv::Vec<float, 12>;

inline Vec3 mean_direction(const DiffuseMoments& m, int channel) {
  const float full = std::max(m[4 * channel], 1e-6f);
  return {m[4 * channel + 1] / full, m[4 * channel + 2] / full, m[4 * channel + 3] / full};
}

struct OcclusionAtNode {
  std::array<Vec3, 3> bend{};  // m as lit minus m without shadow and bounce, per channel
  float ambient_visibility = 1;
};

// `moments` is where the blockers' own radiance is read. `normal`: the best known, unit.
// Direct light: sum of V_i E_i (n.l_i); bounced: (1/pi) integral of D (n.w) over the blocked
// directions, taken as the LEDs' own, each with its solid angle.
std::vector<OcclusionAtNode> occlusion_at_nodes(const Surroundings& around, const LightStage& stage,
                                                const Image3& position_mm, const Image3& normal,
                                                const cv::Mat_<DiffuseMoments>& moments);

}  // namespace lamella::fit
