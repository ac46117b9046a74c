// Pores, freckles, blotches and fine relief: how skin varies within a region.
#pragma once

#include <cstdint>

#include "base/vec.h"

namespace lamella::twin {

class SkinTexture {
 public:
  explicit SkinTexture(uint64_t seed);

  // Factor of the depolarized light, rgb.
  Vec3 albedo(const Vec3& p_mm) const;

  // Factor of the specular intensity c.
  float intensity(const Vec3& p_mm) const;

  // `normal` tilted by fine relief, about 2.5 degrees at strength 1.
  Vec3 bumped(const Vec3& p_mm, const Vec3& normal, float strength) const;

 private:
  uint32_t seed_;
};

}  // namespace lamella::twin
