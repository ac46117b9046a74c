#include "twin/photon_walk.h"

#include <algorithm>
#include <cmath>

#include "twin/random.h"

namespace lamella::twin {

namespace {

constexpr float kRouletteWeight = 0.1f, kRouletteOdds = 0.2f;

struct Photon {
  float x = 0, y = 0, z = 0;  // mm, z down into the skin
  float dx = 0, dy = 0, dz = 1;
  float weight = 1;
  int scatterings = 0;
  bool in_lower = false, has_left_upper = false;
};

float sample_hg_cosine(float g, float u) {
  if (std::abs(g) < 1e-4f) return 2.f * u - 1.f;
  const float t = (1.f - g * g) / (1.f - g + 2.f * g * u);
  return std::clamp((1.f + g * g - t * t) / (2.f * g), -1.f, 1.f);
}

// Uniform point on the unit circle by rejection: cheaper than sine and cosine.
void unit_circle(Random& random, float* c, float* s) {
  for (;;) {
    const float a = 2.f * random.uniform() - 1.f, b = 2.f * random.uniform() - 1.f;
    const float q = a * a + b * b;
    if (q > 1.f || q < 1e-6f) continue;
    const float inverse = 1.f / std::sqrt(q);
    *c = a * inverse, *s = b * inverse;
    return;
  }
}

void turn(Photon& p, float cosine, Random& random) {
  float c, s;
  unit_circle(random, &c, &s);
  const float sine = std::sqrt(std::max(0.f, 1.f - cosine * cosine));
  const float planar = std::sqrt(std::max(0.f, 1.f - p.dz * p.dz));
  if (planar < 1e-4f) {
    p.dx = sine * c, p.dy = sine * s, p.dz = p.dz > 0 ? cosine : -cosine;
    return;
  }
  const float k = sine / planar;
  const float x = k * (p.dx * p.dz * c - p.dy * s) + p.dx * cosine;
  const float y = k * (p.dy * p.dz * c + p.dx * s) + p.dy * cosine;
  p.dz = -sine * c * planar + p.dz * cosine;
  p.dx = x, p.dy = y;
  const float n = 1.f / std::sqrt(p.dx * p.dx + p.dy * p.dy + p.dz * p.dz);  // rounding drifts
  p.dx *= n, p.dy *= n, p.dz *= n;
}

void advance(Photon& p, float distance_mm) {
  p.x += p.dx * distance_mm, p.y += p.dy * distance_mm, p.z += p.dz * distance_mm;
}

class Walk {
 public:
  Walk(const SlabOptics& slab, WalkResult& result) : slab_(slab), result_(result) {
    bottom_mm_ = slab.upper.thickness_mm + slab.lower.thickness_mm;
  }

  void launch(Random& random) {
    Photon p;
    const float lost = fresnel(1.f, 1.f, slab_.ior);
    result_.surface += lost;
    p.weight = 1.f - lost;
    while (step(p, random)) {
    }
  }

 private:
  const LayerOptics& layer(const Photon& p) const { return p.in_lower ? slab_.lower : slab_.upper; }

  // Flies to the next collision through any interfaces. False when the photon is gone.
  bool step(Photon& p, Random& random) {
    float depth_left = -std::log(random.uniform());
    for (;;) {
      const LayerOptics& here = layer(p);
      const float extinction = here.absorption_per_mm + here.scattering_per_mm;
      const float top = p.in_lower ? slab_.upper.thickness_mm : 0.f;
      const float bottom = p.in_lower ? bottom_mm_ : slab_.upper.thickness_mm;
      const float to_wall = p.dz > 0   ? (bottom - p.z) / p.dz
                            : p.dz < 0 ? (top - p.z) / p.dz
                                       : std::numeric_limits<float>::infinity();
      if (depth_left < to_wall * extinction) {
        advance(p, depth_left / extinction);
        return collide(p, here, extinction, random);
      }
      depth_left -= to_wall * extinction;
      advance(p, to_wall);
      if (!cross(p, p.dz > 0 ? bottom : top, random)) return false;
    }
  }

  // Meets the interface at depth `wall_mm`. False when the photon left the skin.
  bool cross(Photon& p, float wall_mm, Random& random) {
    p.z = wall_mm;
    if (p.dz < 0 && !p.in_lower) {
      const float reflected = fresnel(-p.dz, slab_.ior, 1.f);
      if (random.uniform() < reflected) {
        p.dz = -p.dz;
        return true;
      }
      record_exit(p);
      return false;
    }
    const bool out_below = p.dz > 0 && wall_mm >= bottom_mm_;
    if (out_below) {
      result_.transmitted += p.weight;
      if (p.scatterings == 0) result_.unscattered += p.weight;
      return false;
    }
    p.in_lower = p.dz > 0;
    p.has_left_upper = true;
    return true;
  }

  void record_exit(const Photon& p) {
    const Fate fate = p.scatterings == 1 ? Fate::kSingle
                      : p.has_left_upper ? Fate::kDeep
                                         : Fate::kShallow;
    result_.reflected[size_t(fate)] += p.weight;
    const int bin = RadialBins::index(std::hypot(p.x, p.y));
    if (bin >= 0) result_.radial[size_t(fate)][size_t(bin)] += p.weight;
  }

  bool collide(Photon& p, const LayerOptics& here, float extinction, Random& random) {
    const float taken = p.weight * here.absorption_per_mm / extinction;
    result_.absorbed += taken;
    p.weight -= taken;
    if (p.weight < kRouletteWeight) {
      if (random.uniform() >= kRouletteOdds) {
        result_.absorbed += p.weight;  // in the mean what the survivors gain
        return false;
      }
      result_.absorbed -= p.weight * (1.f / kRouletteOdds - 1.f);
      p.weight /= kRouletteOdds;
    }
    ++p.scatterings;
    turn(p, sample_hg_cosine(here.g, random.uniform()), random);
    return true;
  }

  const SlabOptics& slab_;
  WalkResult& result_;
  float bottom_mm_;
};

}  // namespace

int RadialBins::index(float r_mm) {
  static const float scale = float(kCount - 1) / std::log(kLastEdge / kFirstEdge);
  if (r_mm < kFirstEdge) return 0;
  const int i = 1 + int(std::log(r_mm / kFirstEdge) * scale);
  return i < kCount ? i : -1;
}

float RadialBins::edge_mm(int i) {
  if (i <= 0) return 0.f;
  return kFirstEdge * std::pow(kLastEdge / kFirstEdge, float(i - 1) / float(kCount - 1));
}

float fresnel(float cosine, float eta_from, float eta_to) {
  const float sine = eta_from / eta_to * std::sqrt(std::max(0.f, 1.f - cosine * cosine));
  if (sine >= 1.f) return 1.f;
  const float other = std::sqrt(1.f - sine * sine);
  const float s = (eta_from * cosine - eta_to * other) / (eta_from * cosine + eta_to * other);
  const float p = (eta_from * other - eta_to * cosine) / (eta_from * other + eta_to * cosine);
  return 0.5f * (s * s + p * p);
}

WalkResult walk_photons(const SlabOptics& slab, int photons, uint64_t seed) {
  WalkResult result;
  Walk walk(slab, result);
  Random random(seed);
  for (int i = 0; i < photons; ++i) walk.launch(random);
  const double share = 1.0 / photons;
  for (double* total :
       {&result.surface, &result.absorbed, &result.transmitted, &result.unscattered}) {
    *total *= share;
  }
  for (int fate = 0; fate < 3; ++fate) {
    result.reflected[size_t(fate)] *= share;
    for (double& bin : result.radial[size_t(fate)]) bin *= share;
  }
  return result;
}

}  // namespace lamella::twin
