#include "twin/subject.h"

#include <algorithm>

#include "base/error.h"
#include "twin/random.h"
#include "twin/skin_texture.h"
#include "twin/solid_shape.h"

namespace lamella::twin {

namespace {

constexpr float kSphereRadius = 90.f;

// Six sectors: a cap above, a band of four, a cap below.
RegionWeights sphere_regions(const Vec3& p) {
  RegionWeights w{};
  const float soft = 3.f;
  const float top = smooth_step(38.f - soft, 38.f + soft, p[1]);
  const float bottom = smooth_step(38.f - soft, 38.f + soft, -p[1]);
  const float band = 1.f - top - bottom;
  const float right = smooth_step(-soft, soft, p[0]);
  const float outer = smooth_step(38.f - soft, 38.f + soft, std::abs(p[0]));
  w[0] = top;
  w[5] = bottom;
  w[1] = band * (1.f - outer) * (1.f - right);
  w[2] = band * (1.f - outer) * right;
  w[3] = band * outer * (1.f - right);
  w[4] = band * outer * right;
  return w;
}

}  // namespace

Subject make_sphere(uint64_t seed) {
  const SkinTexture texture(seed);
  Subject s;
  s.name = "sphere";
  s.distance_mm = [](const Vec3& p) { return length(p) - kSphereRadius; };
  s.regions = sphere_regions;
  s.labelled = [](const Vec3& p) { return p[2] > 0.35f * kSphereRadius; };
  s.albedo_modulation = [texture](const Vec3& p) { return texture.albedo(p); };
  s.intensity_modulation = [texture](const Vec3& p) { return texture.intensity(p); };
  s.shading_normal = [texture](const Vec3& p, const Vec3& n) { return texture.bumped(p, n, 1.f); };
  return s;
}

Subject make_subject(const std::string& name, uint64_t seed) {
  if (name == "head") return make_head(seed);
  if (name == "sphere") return make_sphere(seed);
  throw_bad_input("--subject", "\"" + name + "\"", "the twin knows head and sphere");
}

int strongest_region(const RegionWeights& weights) {
  return 1 + int(std::max_element(weights.begin(), weights.end()) - weights.begin());
}

}  // namespace lamella::twin
