// Deep dipole and shallow multipole straight from what the dots say, without a free kernel between:
// four numbers, which noise moves little. What the pixels of camera and projector blur is taken
// out.
#pragma once

#include <array>

#include "base/camera.h"
#include "fit/kernel_equations.h"
#include "model/multipole.h"

namespace lamella::fit {

// Bounds of every fit of the layers.
inline constexpr double kHighestAlpha = 0.9999, kLowestAlpha = 0.02;
inline constexpr double kShortestDeepLd_mm = 0.05, kLongestDeepLd_mm = 50;
inline constexpr double kShortestShallowLd_mm = 0.1, kLongestShallowLd_mm = 4;

// Dipole and multipole, each scaled to its share of 1, per mm^2. What is the same at every r is
// reckoned once. s = sqrt(3 (1 - alpha')).
template <class Real>
class LayeredShape {
 public:
  struct Layer {
    Real s, ld_mm;
  };

  LayeredShape(const Layer& deep, const Layer& shallow, double share, double thickness_mm)
      : deep_ld_mm_(deep.ld_mm), shallow_ld_mm_(shallow.ld_mm) {
    const model::Dipole<Real> dermis{model::alpha_from_s(deep.s), deep.ld_mm};
    const model::Multipole<Real> slab{model::alpha_from_s(shallow.s), shallow.ld_mm, thickness_mm};
    deep_real_mm_ = model::transport_length_mm(dermis);
    deep_virtual_mm_ = deep_real_mm_ * (1.0 + 4.0 / 3.0 * model::kBoundaryFactor);
    deep_share_ = (1 - share) / (4 * M_PI) * dermis.alpha / model::diffuse_reflectance_at_s(deep.s);
    shallow_share_ = share / (4 * M_PI) * slab.alpha / model::multipole_total(slab);
    for (int i = -kHalf; i <= kHalf; ++i) source_[size_t(i + kHalf)] = model::source_pair(slab, i);
  }

  Real operator()(double r_mm) const {
    const Real deep = model::source_term(deep_real_mm_, deep_ld_mm_, r_mm) +
                      model::source_term(deep_virtual_mm_, deep_ld_mm_, r_mm);
    Real shallow(0.0);
    for (const model::SourcePair<Real>& z : source_) {
      shallow += model::source_term(z.real_mm, shallow_ld_mm_, r_mm) -
                 model::source_term(z.virtual_mm, shallow_ld_mm_, r_mm);
    }
    return deep_share_ * deep + shallow_share_ * shallow;
  }

 private:
  static constexpr int kHalf = model::kPaperHalfCount;

  Real deep_ld_mm_, shallow_ld_mm_;
  Real deep_real_mm_, deep_virtual_mm_;  // depths of the dipole's sources
  Real deep_share_, shallow_share_;      // of light, over that of the sources
  std::array<model::SourcePair<Real>, 2 * kHalf + 1> source_;
};

struct LayeredKernel {
  double deep_s = 0, deep_ld_mm = 0;
  double shallow_s = 0, shallow_ld_mm = 0;
  double shallow_share = 0, thickness_mm = 0;

  // Per mm^2; integrates to 1 over the plane.
  double operator()(double r_mm) const;
};

// One dipole for all the light: the paper's comparison (its figure 7), and what a skin of one layer
// is.
struct SingleKernel {
  double s = 0, ld_mm = 0;

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

// The same from a solution that is near: of most of the dots, say, from that of all.
LayeredKernel refine_layered_kernel(const WeightEquations& equations, const LayeredKernel& near,
                                    double footprint_mm);

// The same with one dipole, sought around `ld_mm`.
SingleKernel fit_single_kernel(const WeightEquations& equations, double ld_mm, double footprint_mm);

SingleKernel refine_single_kernel(const WeightEquations& equations, const SingleKernel& near,
                                  double footprint_mm);

// What the equations lose by this kernel against the one that they like best: in units of their
// weights, which are one over the variance of a pixel.
double prediction_cost(const WeightEquations& equations, const RadialProfile& kernel, double ld_mm,
                       double footprint_mm);

}  // namespace lamella::fit
