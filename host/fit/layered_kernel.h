// Deep dipole and shallow multipole straight from what the dots say, without a free kernel between:
// four numbers, which noise moves little. What the pixels of camera and projector blur is taken
// out.
#pragma once

#include "base/camera.h"
#include "fit/kernel_equations.h"

namespace lamella::fit {

struct LayeredKernel {
  double deep_s = 0, deep_ld_mm = 0;  // s = sqrt(3 (1 - alpha'))
  double shallow_s = 0, shallow_ld_mm = 0;
  double shallow_share = 0, thickness_mm = 0;

  // Per mm^2; integrates to 1 over the plane.
  double operator()(double r_mm) const;
};

// One sigma of the blur on a surface at the origin that faces camera and projector: of each a
// pixel, which is a box, and a lens.
double footprint_mm(const Camera& camera, const Camera& projector);

// The one that explains the equations best, its share and thickness given; its l_d is sought around
// `ld_mm`, that of the kernel's tail.
LayeredKernel fit_layered_kernel(const WeightEquations& equations, const LayeredKernel& given,
                                 double footprint_mm);

}  // namespace lamella::fit
