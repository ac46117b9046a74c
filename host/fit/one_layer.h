// Whether a skin is one homogeneous layer. Such a skin's kernel is known but for a length: how much
// of the light comes back says how much is absorbed, and with that how its kernel falls from where
// light enters to its tail. A layer that lies on top takes light and spreads it less: to fall as
// such a kernel does, one layer would have to reflect more than is measured; under much melanin,
// less.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "fit/dot_measure.h"

namespace lamella::fit {

// What is measured of a region: its dots, per channel, and its diffuse reflectance.
struct OneLayerRegion {
  RegionEquations dots;
  std::array<double, 3> reflectance{};
};

struct OneLayerVerdict {
  bool is_one = false;
  bool is_told = false;  // or dots say nothing of the excess
  // Logarithm of what one layer with these kernels would reflect over what is measured, and the
  // camera's blur over what is expected.
  double excess = 0, excess_stddev = 0, log_blur = 0;
  std::string why;  // empty: there was nothing to judge by
};

// Of all regions together, which share the light's calibration and the blur. `footprint_mm`: one
// sigma of the blur to expect.
OneLayerVerdict judge_one_layer(const std::vector<OneLayerRegion>& regions, double footprint_mm);

// Weights of the Gaussian basis, summing to 1: a half-space that scatters `scattering_per_mm`
// (mu_s'), as camera and projector see it.
WeightEquations::Vector half_space_weights(double log_absorption, double scattering_per_mm,
                                           double blur_mm);

}  // namespace lamella::fit
