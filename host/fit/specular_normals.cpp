#include "fit/specular_normals.h"

#include <algorithm>

#include "base/filled.h"
#include "base/parallel.h"
#include "fit/smooth.h"

namespace lamella::fit {

namespace {

constexpr float kMirrorFineSigmaMm = 0.3f;
constexpr float kMirrorCoarseSigmaMm = 0.75f;  // about as far as blue light scatters
constexpr float kEnergySigmaMm = 0.75f;
constexpr float kMostSigma_px = 8;
constexpr int kWidest_px = int(2 * kMostSigma_px);  // averages are cut at 2 sigma
constexpr float kMirrorLeastFacing = 0.15f;  // n.v; beyond, r + v is too short to have a direction

struct Specular {
  Vec3 normal{0, 0, 0};  // zero: not known
  float per_moment = 0;  // how far the normal turns (rad) when 2 S_a - S changes by 1
};

Specular specular_normal(const SpecularMoments& m, const Vec3& v) {
  const Vec3 r(m[1], m[2], m[3]);
  const float strength = length(r);
  if (!(strength > 0)) return {};
  const Vec3 h = r * (1 / strength) + v;
  const float twice_facing = length(h);
  if (twice_facing < 2 * kMirrorLeastFacing) return {};
  return {h * (1 / twice_facing), 1 / (strength * twice_facing)};
}

// Variance of one component of 2 S_a - S, mean of the channels, from the two photographs of each.
float moment_variance(const Burst& burst, int y, int x) {
  float variance = 0;
  for (int c = 0; c < 3; ++c) {
    const std::pair<float, const NoiseModel&> photographs[] = {
        {burst.full.parallel(y, x)[c], burst.led_parallel_noise},
        {burst.full.cross(y, x)[c], burst.led_noise}};
    for (const auto& [radiance, noise] : photographs) {
      variance += 4 * noise.variance(0.5f * radiance) + noise.variance(radiance);
    }
  }
  return variance / 9;
}

// Detail (xyz), and its energy and that of noise alone.
struct Detail {
  Image3 turn;
  Image2 energy;
};

Detail measure_detail(const Burst& burst, cv::Mat_<SpecularMoments> raw, const SurfaceView& view,
                      const SurfaceSpan& span) {
  const float fine_px = sigma_px(kMirrorFineSigmaMm, view.px_mm, 0.8f, 3.f);
  const float coarse_px = sigma_px(kMirrorCoarseSigmaMm, view.px_mm, 2 * fine_px, kMostSigma_px);
  const auto fine = smooth_along_surface(raw, span, fine_px);
  const auto coarse = smooth_along_surface(raw, span, coarse_px);
  raw.release();
  const float gain = noise_gain(gaussian_taps(fine_px), gaussian_taps(coarse_px));
  Detail detail{filled<Image3>(fine.size(), Vec3(0, 0, 0)),
                filled<Image2>(fine.size(), Vec2(0, 0))};
  parallel_for(fine.rows, [&](int y) {
    for (int x = 0; x < fine.cols; ++x) {
      if (std::isnan(view.distance_mm(y, x)) || is_clipped(burst.clipped_led, y, x)) continue;
      const Specular sharp = specular_normal(fine(y, x), view.to_camera(y, x));
      const Specular blunt = specular_normal(coarse(y, x), view.to_camera(y, x));
      if (sharp.per_moment == 0 || blunt.per_moment == 0) continue;
      const Vec3 turn = sharp.normal - blunt.normal;
      const float noise =
          2 * gain * moment_variance(burst, y, x) * blunt.per_moment * blunt.per_moment;
      detail.turn(y, x) = turn;
      detail.energy(y, x) = Vec2(dot(turn, turn), noise);
    }
  });
  return detail;
}

}  // namespace

cv::Mat_<SpecularMoments> specular_moments(const Burst& burst, const Image1& distance_mm) {
  cv::Mat_<SpecularMoments> moments(distance_mm.size());
  parallel_for(moments.rows, [&](int y) {
    for (int x = 0; x < moments.cols; ++x) {
      if (std::isnan(distance_mm(y, x))) continue;
      const float full = mean(burst.full.parallel(y, x) - burst.full.cross(y, x));
      moments(y, x)[0] = full;
      for (size_t a = 0; a < 3; ++a) {
        const AnalyserPair& g = burst.gradient[a];
        moments(y, x)[int(a) + 1] = 2 * mean(g.parallel(y, x) - g.cross(y, x)) - full;
      }
      if (is_clipped(burst.clipped_led, y, x)) moments(y, x) *= 0;
    }
  });
  return moments;
}

Image3 add_specular_detail(const Burst& burst, cv::Mat_<SpecularMoments> moments,
                           const SurfaceView& view, const Image3& base) {
  const SurfaceSpan span(view.distance_mm, view.px_mm, kWidest_px);
  const Detail detail = measure_detail(burst, std::move(moments), view, span);
  const float energy_px = sigma_px(kEnergySigmaMm, view.px_mm, 2.f, kMostSigma_px);
  const Image2 energy = smooth_along_surface(detail.energy, span, energy_px);
  Image3 normal = base.clone();
  parallel_for(normal.rows, [&](int y) {
    for (int x = 0; x < normal.cols; ++x) {
      const Vec2& e = energy(y, x);
      if (!is_finite(base(y, x)) || !(e[0] > e[1])) continue;
      normal(y, x) = unit(base(y, x) + detail.turn(y, x) * (1 - e[1] / e[0]));
    }
  });
  return normal;
}

}  // namespace lamella::fit
