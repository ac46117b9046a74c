#include "twin/skin_texture.h"

#include <algorithm>

#include "twin/random.h"
#include "twin/solid_noise.h"
#include "twin/solid_shape.h"

namespace lamella::twin {

SkinTexture::SkinTexture(uint64_t seed) : seed_(uint32_t(mix_bits(seed ^ 0x7e47))) {}

Vec3 SkinTexture::albedo(const Vec3& p) const {
  const float blotch = fractal_noise(p * (1.f / 14.f), 3, seed_);
  const float pores = solid_noise(p * (1.f / 0.9f), seed_ + 11).value;
  Vec3 factor(1.f + 0.03f * blotch, 1.f + 0.07f * blotch, 1.f + 0.06f * blotch);
  factor *= 1.f + 0.035f * pores;
  const Spot spot = nearest_spot(p * (1.f / 7.f), seed_ + 23);
  const float size = 0.06f + 0.12f * spot.number;
  const float ink = spot.number > 0.45f ? 1.f - smooth_step(0.6f * size, size, spot.distance) : 0.f;
  return factor.mul(Vec3(1.f - 0.13f * ink, 1.f - 0.24f * ink, 1.f - 0.30f * ink));
}

float SkinTexture::intensity(const Vec3& p) const {
  const float broad = fractal_noise(p * (1.f / 22.f), 2, seed_ + 31);
  const float fine = fractal_noise(p * (1.f / 1.6f), 2, seed_ + 37);
  return std::clamp(1.f + 0.22f * broad + 0.14f * fine, 0.4f, 1.6f);
}

Vec3 SkinTexture::bumped(const Vec3& p, const Vec3& normal, float strength) const {
  // Heights in mm over wavelengths of about 2 and 5 mm.
  Vec3 slope(0, 0, 0);
  for (const auto& [cell_mm, height_mm] : {std::pair{1.3f, 0.018f}, std::pair{3.1f, 0.035f}}) {
    slope += solid_noise(p * (1.f / cell_mm), seed_ + uint32_t(100 * cell_mm)).gradient *
             (height_mm / cell_mm);
  }
  slope *= strength;
  return unit(normal - (slope - normal * dot(slope, normal)));
}

}  // namespace lamella::twin
