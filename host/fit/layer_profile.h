// From a scattering kernel to the parameters that a renderer uses: the multipole that completes the
// dipole of its tail.
#pragma once

#include <array>
#include <string>

#include "fit/deep_profile.h"

namespace lamella::fit {

// Slabs that the shallow layer may be, mm: the paper's (sec. 4.2), and those in which what stripes
// call shallow spreads further, as it does in light skin: all that comes back within their width.
// Which of them it is says what explains the kernels, not how thick skin is.
inline constexpr std::array<double, 3> kSlabs_mm{0.5, 1, 2};

struct LayeredProfile {
  double thickness_mm = kSlabs_mm[0];
  double cost = 0;  // half the squared residuals, in units of the kernel's error
  double alpha_dot = 0, alpha_dot_stddev = 0;
  double shallow_alpha = 0, shallow_alpha_stddev = 0;
  double shallow_ld_mm = 0, shallow_ld_mm_stddev = 0;
  double deep_rms = 0, shallow_rms = 0;  // relative, weighted by the light
  bool shallow_fitted = false;
  std::string shallow_why;
  std::string deep_at_bound, shallow_at_bound;  // as DeepProfile's
};

// What the stripes measured of the shallow layer.
struct ShallowLight {
  double share = 0;   // of all diffuse light
  double albedo = 0;  // reflectance
};

// What is known of a channel before its kernel is looked at.
struct KnownSkin {
  SkinPrior prior;
  ShallowLight shallow;
};

// Deep dipole of mean free path `ld_mm` and shallow multipole together, to the whole kernel. Their
// integrals are in the proportion that the stripes measured, and the multipole's is about the
// albedo that these did (sec. 4.2). A kernel hardly tells alpha' and l_d of either layer from each
// other: what it leaves open is as tissue has it. One for each of kSlabs_mm.
using SlabProfiles = std::array<LayeredProfile, kSlabs_mm.size()>;
SlabProfiles fit_layered_profiles(const RadialProfile& kernel, const DeepProfile& deep,
                                  const KnownSkin& known);

// Which of kSlabs_mm explains the kernels of all channels best: skin has one thickness.
size_t best_slab(const std::array<SlabProfiles, 3>& channels);

// Of each channel what it is on that slab; slabs that explain the kernels hardly worse widen its
// deviations.
std::array<LayeredProfile, 3> on_best_slab(const std::array<SlabProfiles, 3>& channels);

// Adds deviations, the figures of `by`, to those of `profile`.
void widen(const LayeredProfile& by, LayeredProfile* profile);

// The same from a solution that is near, of the figures alone: of other dots, say.
LayeredProfile refine_layered_profile(const RadialProfile& kernel, const DeepProfile& deep,
                                      const KnownSkin& known, const LayeredProfile& near);

}  // namespace lamella::fit
