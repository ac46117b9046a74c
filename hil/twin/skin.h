// The skins of the twin's subjects: six regions with optics of their own, and what the Monte Carlo
// makes of them, tabulated.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "base/vec.h"
#include "twin/photon_walk.h"

namespace lamella::twin {

inline constexpr int kRegionCount = 6;
inline constexpr float kIor = 1.38f;

// Labels 1 to 6 of regions.png, in this order.
extern const std::array<const char*, kRegionCount> kRegionNames;

// What there is to find in a subject's skin, chosen by name.
enum class SkinKind {
  kLayered,   // an epidermis over a dermis
  kOneLayer,  // the dermis alone: no shallow light, single scattering is the dermis's
  kNoSingle,  // layered, but light that was scattered once does not keep its polarization
  kDark,      // layered, with much melanin
  kLight,     // layered, with hardly any melanin and little blood
};

// "layered", "one_layer", "no_single", "dark", "light". Throws Error that lists them for any other.
SkinKind skin_kind(const std::string& name);

struct Skin {
  std::array<float, 3> epidermis_absorption_per_mm, epidermis_reduced_scattering_per_mm;
  std::array<float, 3> dermis_absorption_per_mm, dermis_reduced_scattering_per_mm;
  float epidermis_mm;  // 0: none
  float roughness;     // m of the Beckmann distribution
  float intensity;     // mean c of eq. 1
  bool single_is_polarized = true;

  bool has_epidermis() const { return epidermis_mm > 0.f; }
};

// Published ranges of facial skin, varied a little with the seed.
std::array<Skin, kRegionCount> facial_skins(uint64_t seed, SkinKind kind = SkinKind::kLayered);

// Mean cosine of scattering per channel, both layers, every region.
inline constexpr std::array<float, 3> kPhaseG{0.64f, 0.67f, 0.69f};

SlabOptics slab_of(const Skin& skin, int channel);

// What comes back around a thin beam, per area: R(r) on a linear grid of r, by kind of light.
struct Profile {
  static constexpr int kCount = 1600;
  static constexpr float kStep = 0.01f;  // mm
  static float radius_mm(int i) { return (float(i) + 0.5f) * kStep; }

  std::array<float, kCount> shallow{}, deep{};                 // 1/mm^2
  double single_total = 0, shallow_total = 0, deep_total = 0;  // of the launched energy

  float at(int i) const { return shallow[size_t(i)] + deep[size_t(i)]; }
  double total() const { return shallow_total + deep_total; }
};

Profile profile_from_walk(const WalkResult& walk);

using SkinProfiles = std::array<std::array<Profile, 3>, kRegionCount>;

// All eighteen walks, over all cores.
SkinProfiles walk_skins(const std::array<Skin, kRegionCount>& skins, int photons, uint64_t seed);

// Albedo of single scattering in the form of eq. 3 as printed: of the layer on top, over ior^2. 0
// where it does not keep its polarization.
float single_albedo(const Skin& skin, int channel);

}  // namespace lamella::twin
