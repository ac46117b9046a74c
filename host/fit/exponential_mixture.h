// A scattering kernel as a sum of exponentials of many lengths, none of them negative: what
// scattered light does, it falls with distance and ever more slowly. Gaussians with free weights
// ripple by a fifth where dots say little, and by as much the tail's slope is off.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "fit/kernel_equations.h"

namespace lamella::fit {

struct ExponentialMixture {
  static constexpr int kSize = 36;
  static constexpr double kShortest_mm = 0.03, kLongest_mm = 8;

  std::array<double, kSize> weight{};  // of exp(-r/l)/(2 pi l^2); not negative, sum 1
  double cost = 0;                     // squared error of as many samples as the equations count as

  static double length_mm(int k);  // geometric

  // Per mm^2 at r; integrates to 1 over the plane.
  double operator()(double r_mm) const;
};

// What camera and projector leave of each exponential, one sigma of the blur being `blur_mm`, as
// weights of the Gaussian basis: GaussianBasis::kSize x ExponentialMixture::kSize.
cv::Mat1d blurred_exponentials(double blur_mm);

// Least x'ax - 2b'x over x not negative, kSize unknowns, the sum of 1 as one more equation that is
// much stiffer than the data.
struct MixtureProgram {
  cv::Mat1d a, b;
};

// `smoothness`: how strongly neighbouring weights are pulled to a straight line.
MixtureProgram mixture_program(const KernelEquations& equations, double offset_sigma,
                               const cv::Mat1d& blurred, double smoothness);

// Its cost is left at 0.
ExponentialMixture solve_program(const MixtureProgram& program);

// The mixture that explains the equations best, the offset within `offset_sigma`.
ExponentialMixture solve_mixture(const KernelEquations& equations, double offset_sigma,
                                 const cv::Mat1d& blurred, double smoothness);

// One sigma of the blur that all of a session's kernels agree on, mm, with what its pixels let one
// expect. Too small a blur leaves a corner of the dots' edges to the kernels, which have none to
// give; too large a one cannot be undone.
double shared_blur_mm(const std::vector<KernelEquations>& kernels, double offset_sigma,
                      double expected_mm);

// Of dots: how smooth the tail is, and so smooth that it shows how much of the tail the dots leave
// open.
inline constexpr double kTailSmoothness = 72, kStiffSmoothness = 720;

}  // namespace lamella::fit
