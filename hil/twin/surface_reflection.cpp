#include "twin/surface_reflection.h"

#include <algorithm>
#include <cmath>

namespace lamella::twin {

namespace {

// Direction below the interface of a direction `w` above it, still pointing away from the surface.
Vec3 refracted(const Vec3& n, const Vec3& w) {
  const float cosine = dot(n, w);
  const Vec3 tangential = (w - n * cosine) * (1.f / kIor);
  return tangential + n * std::sqrt(std::max(0.f, 1.f - dot(tangential, tangential)));
}

}  // namespace

float facet_density(float cosine_h, float roughness) {
  if (cosine_h <= 0.f) return 0.f;
  const float c2 = cosine_h * cosine_h, m2 = roughness * roughness;
  return std::exp((c2 - 1.f) / (m2 * c2)) / (kPi * m2 * c2 * c2);
}

float surface_lobe(const Vec3& n, const Vec3& l, const Vec3& v, float roughness) {
  const Vec3 h = unit(l + v);
  const float nh = dot(n, h), nl = dot(n, l), nv = dot(n, v), vh = dot(v, h);
  if (nh <= 0.3f || nl <= 0.f || nv <= 0.f || vh <= 0.f) return 0.f;  // e^-40 beyond
  const float groove = std::min({1.f, 2.f * nh * nv / vh, 2.f * nh * nl / vh});
  return facet_density(nh, roughness) * fresnel(vh, 1.f, kIor) * groove / (nl * nv);
}

LobeLoss::LobeLoss(float roughness) {
  constexpr int kThetas = 64, kPhis = 64;
  const Vec3 n(0, 0, 1);
  for (int i = 0; i < kCount; ++i) {
    const float cosine = std::max(0.02f, float(i) / (kCount - 1));
    const Vec3 v(std::sqrt(1.f - cosine * cosine), 0, cosine);
    double sum = 0;
    for (int a = 0; a < kThetas; ++a) {
      const float cos_l = (float(a) + 0.5f) / kThetas, sin_l = std::sqrt(1.f - cos_l * cos_l);
      for (int b = 0; b < kPhis; ++b) {
        const float phi = 2.f * kPi * (float(b) + 0.5f) / kPhis;
        const Vec3 l(sin_l * std::cos(phi), sin_l * std::sin(phi), cos_l);
        sum += double(surface_lobe(n, l, v, roughness)) * cos_l;
      }
    }
    loss_[size_t(i)] = float(sum * 2.0 * kPi / (kThetas * kPhis));
  }
}

float LobeLoss::operator()(float cosine) const {
  const float x = std::clamp(cosine, 0.f, 1.f) * (kCount - 1);
  const int i = std::min(int(x), kCount - 2);
  return loss_[size_t(i)] + (x - float(i)) * (loss_[size_t(i + 1)] - loss_[size_t(i)]);
}

Vec3 single_scattering(const Vec3& n, const Vec3& l, const Vec3& v, float transmitted) {
  const Vec3 below_l = refracted(n, l), below_v = refracted(n, v);
  const float cosine = -dot(below_l, below_v);
  const float through = transmitted / (4.f * kPi * (dot(n, below_l) + dot(n, below_v)));
  Vec3 f;
  for (int c = 0; c < 3; ++c) {
    const float g = kPhaseG[size_t(c)], q = 1.f + g * g - 2.f * g * cosine;
    f[c] = through * (1.f - g * g) / (q * std::sqrt(q));
  }
  return f;
}

}  // namespace lamella::twin
