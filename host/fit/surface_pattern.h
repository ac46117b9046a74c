// How the projector's pixels lie on the surface.
#pragma once

#include "base/camera.h"

namespace lamella::fit {

// Gradients of the projector's column u and row v along the surface, px per mm, rig frame.
struct PatternGradient {
  Vec3 u, v;
};

// At `x_mm` on a surface with unit normal `n`; the projector's distortion is left out, which bends
// the gradient by less than it bends the picture.
inline PatternGradient pattern_gradient(const Camera& projector, const Vec3& x_mm, const Vec3& n) {
  const Mat33d& r = projector.cam_from_rig;
  const Vec3d x = r * Vec3d(x_mm) + projector.translation_mm;
  const auto along_surface = [&](int axis, double focal) {
    Vec3 g;
    for (int i = 0; i < 3; ++i) {
      g[i] = float(focal * (r(axis, i) - x[axis] / x[2] * r(2, i)) / x[2]);
    }
    return g - n * dot(n, g);
  };
  return {along_surface(0, projector.fx), along_surface(1, projector.fy)};
}

}  // namespace lamella::fit
