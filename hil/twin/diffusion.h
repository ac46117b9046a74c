// Light that scatters from where it enters the surface to where it leaves: the Monte Carlo profiles
// convolved with the irradiance over the surface itself. Linear in the light.
#pragma once

#include <array>
#include <vector>

#include "twin/skin.h"
#include "twin/subject.h"
#include "twin/surface.h"

namespace lamella::twin {

// rgb and one spare, so that a sample is one register.
using Rgb4 = float __attribute__((vector_size(16)));

// Vertices gathered into ever larger patches: level 0 has one vertex a patch, each further level
// four patches of the one before.
class PatchTree {
 public:
  struct Patch {
    Vec3 centre_mm;
    float radius_mm;  // of a ball around the centre that holds every vertex
    float area_mm2;
  };
  static constexpr int kLevels = 6;

  explicit PatchTree(const Surface& surface);

  struct Level {
    int rows, columns;
    std::vector<Patch> patches;
    int offset;  // of the first patch in the numbering over all levels
  };
  const Level& level(int i) const { return levels_[size_t(i)]; }
  int size() const { return size_; }

 private:
  std::array<Level, kLevels> levels_;
  int size_ = 0;
};

// Power (irradiance times area) that falls on every patch, numbered over all levels.
using PatchLight = std::vector<Rgb4>;

// `irradiance` per vertex, rgb.
PatchLight gather_light(const PatchTree& tree, const std::vector<Vec3>& irradiance);

// Points where scattered light is asked for, in blocks that lie close together.
struct ScatterTargets {
  std::vector<Vec3> position_mm;
  std::vector<RegionWeights> regions;
  std::vector<std::vector<int>> blocks;  // indices of targets
};

class Diffusion {
 public:
  Diffusion(const Surface& surface, const SkinProfiles& profiles);

  const PatchTree& tree() const { return tree_; }

  // Depolarized radiance (a white Lambertian surface shows its irradiance) at every target under
  // every light: result[light][target]. At each target the kernel is normalised to the region's
  // whole diffuse reflectance, so even light gives exactly that.
  std::vector<std::vector<Vec3>> scatter(const ScatterTargets& targets,
                                         const std::vector<const PatchLight*>& lights) const;

 private:
  static constexpr int kSizes = 6;  // patches of 0.4 mm, 0.8 mm, ... a side
  using Table = std::array<Rgb4, Profile::kCount>;
  struct Source;

  void collect_sources(const Vec3& centre_mm, float radius_mm, std::vector<Source>* sources) const;
  template <int kLights>
  void scatter_block(const ScatterTargets& targets, const std::vector<int>& block,
                     const std::vector<const PatchLight*>& lights,
                     std::vector<std::vector<Vec3>>* radiance) const;

  PatchTree tree_;
  std::vector<Table> tables_;              // region * kSizes + size
  std::array<Rgb4, kRegionCount> totals_;  // diffuse reflectance
};

}  // namespace lamella::twin
