#include "fit/diffuse_moments.h"

#include <algorithm>

#include "base/parallel.h"
#include "fit/order_statistics.h"
#include "fit/smooth.h"

namespace lamella::fit {

namespace {

// Each average gives way to the next where noise alone parts them. The finest is less than light
// scatters, the second of a cheek: a nostril is finer.
struct Width {
  float sigma_mm, most_px;
};
constexpr Width kWidths[] = {{0.5f, 4}, {3, 20}, {8, 40}};
constexpr float kQuietRad = 0.012f;   // of noise in a normal: less is not worth a wider average
constexpr float kNoiseMargin = 1.2f;  // the energy of some pixels' noise is itself uncertain
// Of a clipped pixel in an average: its neighbours speak for it, where it has any that are not.
constexpr float kClippedWeight = 1e-3f;
constexpr float kEnergyWidth = 1.6f;  // of the wider average's

struct Average {
  float width_px;
  std::vector<float> taps;
  cv::Mat_<DiffuseMoments> moments;
};

using PerChannel = cv::Vec<float, 6>;  // energy of what is fine, and of noise alone, by channel

cv::Mat_<DiffuseMoments> raw_moments(const Burst& burst, const Image1& distance_mm) {
  cv::Mat_<DiffuseMoments> moments(burst.regions.size());
  parallel_for(moments.rows, [&](int y) {
    for (int x = 0; x < moments.cols; ++x) {
      if (std::isnan(distance_mm(y, x))) continue;
      const Vec3 full = burst.full.cross(y, x) * 2.f;
      DiffuseMoments& m = moments(y, x);
      for (int c = 0; c < 3; ++c) m[4 * c] = full[c];
      for (int a = 0; a < 3; ++a) {
        const Vec3 g = burst.gradient[size_t(a)].cross(y, x) * 4.f - full;
        for (int c = 0; c < 3; ++c) m[4 * c + 1 + a] = g[c];
      }
      for (int c = 0; c < 3 && is_clipped(burst.clipped_led_cross, y, x); ++c) {
        if (!burst.clipped_led_cross(y, x)[c]) continue;
        for (int i = 4 * c; i < 4 * c + 4; ++i) m[i] *= kClippedWeight;
      }
    }
  });
  return moments;
}

// What noise of one pixel adds to the squared length of the mean direction m = 2 g / full - 1, for
// the channel.
float noise_energy(const Burst& burst, const DiffuseMoments& moments, int channel) {
  const float full = std::max(0.5f * moments[4 * channel], 1e-6f);  // through the analyser
  const Vec3 m = mean_direction(moments, channel);
  float variance = 0;
  for (int a = 0; a < 3; ++a) {
    const float share = 0.5f * (1 + m[a]);
    variance += burst.led_noise.variance(std::max(share, 0.f) * full) +
                share * share * burst.led_noise.variance(full);
  }
  return 4 * variance / (full * full);
}

// What noise turns the normals by that an average gives, one sigma, in the green channel: the
// median over the face.
float noise_of(const Burst& burst, const Average& average, const Image1& distance_mm) {
  constexpr int kEvery_px = 7;
  const float gain = noise_gain(average.taps);
  std::vector<float> sigma;
  for (int y = 0; y < average.moments.rows; y += kEvery_px) {
    for (int x = 0; x < average.moments.cols; x += kEvery_px) {
      if (!burst.regions(y, x) || std::isnan(distance_mm(y, x))) continue;
      sigma.push_back(std::sqrt(2 / 3.f * gain * noise_energy(burst, average.moments(y, x), 1)));
    }
  }
  return sigma.empty() ? 0 : median_of(&sigma);
}

// Replaces in `fine` what noise alone explains by `coarse`.
void keep_what_rises_above_noise(const Burst& burst, const Average& coarse,
                                 const Image1& distance_mm, float px_mm, Average* fine) {
  const float gain = noise_gain(fine->taps, coarse.taps);
  cv::Mat_<PerChannel> energy(fine->moments.size());
  parallel_for(fine->moments.rows, [&](int y) {
    for (int x = 0; x < fine->moments.cols; ++x) {
      if (std::isnan(distance_mm(y, x))) continue;
      for (int c = 0; c < 3; ++c) {
        const Vec3 turn =
            mean_direction(fine->moments(y, x), c) - mean_direction(coarse.moments(y, x), c);
        energy(y, x)[c] = dot(turn, turn);
        energy(y, x)[3 + c] = gain * noise_energy(burst, coarse.moments(y, x), c);
      }
    }
  });
  const float energy_px = kEnergyWidth * coarse.width_px;
  energy = smooth_along_surface(energy, span_for(distance_mm, px_mm, energy_px), energy_px);
  parallel_for(fine->moments.rows, [&](int y) {
    for (int x = 0; x < fine->moments.cols; ++x) {
      if (std::isnan(distance_mm(y, x))) continue;
      DiffuseMoments& m = fine->moments(y, x);
      for (int c = 0; c < 3; ++c) {
        const float all = energy(y, x)[c], noise = energy(y, x)[3 + c];
        const float kept = std::max(0.f, 1 - kNoiseMargin * noise / all);
        const Vec3 base = mean_direction(coarse.moments(y, x), c);
        const Vec3 direction = base + (mean_direction(m, c) - base) * kept;
        for (int a = 0; a < 3; ++a) m[4 * c + 1 + a] = m[4 * c] * direction[a];
      }
    }
  });
}

}  // namespace

cv::Mat_<DiffuseMoments> diffuse_moments(Burst* burst, const Image1& distance_mm, float px_mm) {
  cv::Mat_<DiffuseMoments> raw = raw_moments(*burst, distance_mm);
  forget_gradients(burst);
  std::vector<Average> averages;
  for (const Width& width : kWidths) {
    const float least_px = averages.empty() ? 1.2f : 2 * averages.back().width_px;
    const float width_px =
        sigma_px(width.sigma_mm, px_mm, least_px, std::max(least_px, width.most_px));
    averages.push_back(
        {width_px, gaussian_taps(width_px),
         smooth_along_surface(raw, span_for(distance_mm, px_mm, width_px), width_px)});
    if (noise_of(*burst, averages.back(), distance_mm) < kQuietRad) break;
  }
  raw.release();
  for (size_t i = averages.size() - 1; i-- > 0;) {
    keep_what_rises_above_noise(*burst, averages[i + 1], distance_mm, px_mm, &averages[i]);
    averages.pop_back();
  }
  return averages[0].moments;
}

}  // namespace lamella::fit
