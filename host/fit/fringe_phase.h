// The projector column that lights each pixel, decoded from the colour fringes.
#pragma once

#include <vector>

#include "fit/burst.h"

namespace lamella::fit {

// What the fringes are (session-format: Patterns) and how noisy a camera sees them.
struct FringeCode {
  std::vector<double> periods;  // across the projector's width, rising
  double projector_width_px = 0;
  NoiseModel noise;
};

struct ProjectorColumns {
  Image1 u_px;      // projector column; NaN where the fringes do not tell
  Image1 sigma_px;  // one sigma from the camera's noise
};

// Channel c of fringe k over white is 0.5 + a_c cos(2 pi N_k u / W + (c - 1) 2 pi / 3). Scattering
// blurs red more than blue, so the contrasts a_c of the finest level (0.5 on paper) are measured,
// tile by tile: with equal ones its phase is wrong by up to 0.16 rad. The coarser levels count its
// turns. `fringe` and `white` have the projector's black level removed; `wanted` says where to
// look.
ProjectorColumns decode_columns(const std::vector<Image3>& fringe, const Image3& white,
                                const Mask& wanted, const FringeCode& code);

}  // namespace lamella::fit
