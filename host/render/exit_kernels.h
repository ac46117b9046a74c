// The scattering profiles of each region: eq. 7 for deep light, the multipole for shallow light,
// both scaled to integrate to 1, so that the albedo maps alone say how much comes back.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "render/cluster_tree.h"
#include "render/subject.h"

namespace lamella::render {

class RegionKernels {
 public:
  explicit RegionKernels(const Subject& subject);

  // The dipole of the region's `alpha_dot` (without it, of its albedo by eq. 8) at diffuse mean
  // free paths `ld_mm`. A channel without a positive length has no kernel.
  ExitKernels deep(int label, const Vec3& ld_mm) const;

  // The multipole; no kernel where the layer was dropped or where diffusion gives it no light.
  ExitKernels shallow(int label) const;

 private:
  using Channels = std::array<std::unique_ptr<RadialKernel>, 3>;
  struct Region {
    Channels deep, shallow;
    Vec3 shallow_per_mm{1, 1, 1};
  };

  std::vector<Region> regions_;  // by label
};

}  // namespace lamella::render
