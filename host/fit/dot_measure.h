// What each projected dot says about the scattering kernel of the skin it lies on.
#pragma once

#include <vector>

#include "fit/kernel_equations.h"
#include "fit/normals.h"

namespace lamella::fit {

// One dot and the light between it and its neighbours.
struct Dot {
  int label = 0;                             // the region it lies on
  std::array<KernelEquations, 3> equations;  // per channel; values are DOTS/(FRONT - BLACK)
  double pixels = 0;                         // of its region; a channel may have fewer with light
};

// Dots that lie on one region and face the projector. A channel without enough light has no
// equations.
std::vector<Dot> measure_dots(const Burst& burst, const Geometry& geometry, const Normals& normals);

// Per channel, of the dots on region `label` that have enough light in it.
using RegionEquations = std::array<std::vector<const KernelEquations*>, 3>;
RegionEquations equations_of_region(const std::vector<Dot>& dots, int label);

}  // namespace lamella::fit
