// Monte Carlo of photons in a slab of up to two layers under a smooth interface: the source of all
// scattering in the twin. Nothing here is a diffusion formula.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace lamella::twin {

struct LayerOptics {
  float absorption_per_mm = 0;  // mu_a
  float scattering_per_mm = 1;  // mu_s
  float g = 0;                  // mean cosine, Henyey-Greenstein
  float thickness_mm = std::numeric_limits<float>::infinity();
};

// Two layers of index `ior` under air; the lower one may be infinite, and either of thickness 0 (a
// single slab). What lies below reflects nothing.
struct SlabOptics {
  LayerOptics upper, lower;
  float ior = 1.38f;
};

enum class Fate {
  kSingle,
  kShallow,
  kDeep
};  // scattered once; never left the upper layer; the rest

// Radial bins of the light that comes back: logarithmic from kFirstEdge to kLastEdge mm; the first
// bin also holds what comes back nearer, light beyond the last edge is in the totals alone.
struct RadialBins {
  static constexpr int kCount = 96;
  static constexpr float kFirstEdge = 0.01f, kLastEdge = 20.f;
  static int index(float r_mm);  // -1 beyond the last edge
  static float edge_mm(int i);   // lower edge of bin i; 0 for the first
};

struct WalkResult {
  double surface = 0;                 // Fresnel-reflected before entering
  std::array<double, 3> reflected{};  // by Fate, share of the launched energy
  double absorbed = 0, transmitted = 0;
  double unscattered = 0;  // part of `transmitted` that met nothing
  std::array<std::array<double, RadialBins::kCount>, 3> radial{};  // per Fate, share per bin

  double diffuse_reflectance() const { return reflected[0] + reflected[1] + reflected[2]; }
};

// Launches `photons` along the inward normal at the origin. The same seed gives the same result.
WalkResult walk_photons(const SlabOptics& slab, int photons, uint64_t seed);

// Unpolarized Fresnel reflectance from index `eta_from` into `eta_to`, `cosine` on the side of
// `eta_from`; 1 at total reflection.
float fresnel(float cosine, float eta_from, float eta_to);

}  // namespace lamella::twin
