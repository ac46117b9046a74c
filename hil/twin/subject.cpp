#include "twin/subject.h"

#include <algorithm>

#include "base/error.h"
#include "twin/random.h"
#include "twin/skin_texture.h"
#include "twin/solid_shape.h"

namespace lamella::twin {

namespace {

constexpr float kSphereRadius = 90.f;

// Six wedges that meet at the front, so that every skin is seen at every angle to the light.
RegionWeights sphere_regions(const Vec3& p) {
  constexpr float kSoft = 3.f, kHalfWedge = kPi / kRegionCount;
  const float out = std::hypot(p[0], p[1]), azimuth = std::atan2(p[1], p[0]);
  RegionWeights w{};
  float sum = 0;
  for (int k = 0; k < kRegionCount; ++k) {
    const float from_middle = std::abs(std::remainder(azimuth - (2 * k + 1) * kHalfWedge, 2 * kPi));
    const float inside_mm = out * std::sin(std::max(kHalfWedge - from_middle, -kPi / 2));
    w[size_t(k)] = smooth_step(-kSoft, kSoft, inside_mm);
    sum += w[size_t(k)];
  }
  for (float& x : w) x /= sum;
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

void require_subject(const std::string& name) {
  if (name == "head" || name == "sphere") return;
  throw_bad_input("--subject", "\"" + name + "\"", "the twin knows head and sphere");
}

Subject make_subject(const std::string& name, uint64_t seed) {
  require_subject(name);
  return name == "head" ? make_head(seed) : make_sphere(seed);
}

int strongest_region(const RegionWeights& weights) {
  return 1 + int(std::max_element(weights.begin(), weights.end()) - weights.begin());
}

}  // namespace lamella::twin
