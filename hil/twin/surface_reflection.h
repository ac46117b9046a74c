// What skin returns with its polarization kept: a white microfacet surface and light scattered
// once below it. Values are BRDFs (per steradian); `n`, `l`, `v` are unit vectors away from the
// surface, and all cosines with n are positive.
#pragma once

#include <array>

#include "base/vec.h"
#include "twin/skin.h"

namespace lamella::twin {

// Beckmann's distribution of facets: per steradian, integral of p cos over the hemisphere is 1.
float facet_density(float cosine_h, float roughness);

// Eq. 1 without the factor c: p(h) F(v.h) G / ((l.n)(v.n)), V-groove masking G.
float surface_lobe(const Vec3& n, const Vec3& l, const Vec3& v, float roughness);

// Share of a beam along a direction with this cosine that the surface lobe (times c) returns.
class LobeLoss {
 public:
  explicit LobeLoss(float roughness);
  float operator()(float cosine) const;

 private:
  static constexpr int kCount = 65;
  std::array<float, kCount> loss_{};
};

// Eq. 3 with albedo 1, per channel: T(l) T(v) p(cos) / (n.l' + n.v'), primes refracted,
// Henyey-Greenstein of `kPhaseG` with the cosine between the propagation directions. `transmitted`
// is T(l) T(v).
Vec3 single_scattering(const Vec3& n, const Vec3& l, const Vec3& v, float transmitted);

}  // namespace lamella::twin
