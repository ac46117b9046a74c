#include "fit/diffuse_moments.h"

#include <algorithm>

#include "base/parallel.h"
#include "fit/smooth.h"

namespace lamella::fit {

namespace {

constexpr float kFineSigmaMm = 0.5f;    // less than light scatters
constexpr float kCoarseSigmaMm = 2.5f;  // of a cheek; a nostril is finer
constexpr float kQuietRad = 0.012f;     // of noise in a normal: less is not worth a coarse average

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
    }
  });
  return moments;
}

// Variance of one component of the mean direction, of one pixel: m = 2 g/full - 1.
float direction_variance(const Burst& burst, float full) {
  const float least = std::max(full, 1e-6f);
  return (4 * burst.led_noise.variance(0.5f * full) + burst.led_noise.variance(full)) /
         (least * least);
}

// What noise turns the normals by that `fine` averages give, one sigma, in the green channel: the
// median over the face.
float noise_of(const Burst& burst, const cv::Mat_<DiffuseMoments>& fine, const Image1& distance_mm,
               float gain) {
  constexpr int kEvery_px = 7;
  std::vector<float> sigma;
  for (int y = 0; y < fine.rows; y += kEvery_px) {
    for (int x = 0; x < fine.cols; x += kEvery_px) {
      if (!burst.regions(y, x) || std::isnan(distance_mm(y, x))) continue;
      sigma.push_back(std::sqrt(2 * gain * direction_variance(burst, 0.5f * fine(y, x)[4])));
    }
  }
  if (sigma.empty()) return 0;
  std::nth_element(sigma.begin(), sigma.begin() + std::ptrdiff_t(sigma.size() / 2), sigma.end());
  return sigma[sigma.size() / 2];
}

// Replaces in `fine` what noise alone explains by `coarse`.
void keep_what_rises_above_noise(const Burst& burst, const cv::Mat_<DiffuseMoments>& coarse,
                                 const Image1& distance_mm, float gain, float energy_px,
                                 float px_mm, cv::Mat_<DiffuseMoments>* fine) {
  cv::Mat_<PerChannel> energy(fine->size());
  parallel_for(fine->rows, [&](int y) {
    for (int x = 0; x < fine->cols; ++x) {
      if (std::isnan(distance_mm(y, x))) continue;
      for (int c = 0; c < 3; ++c) {
        const Vec3 turn = mean_direction((*fine)(y, x), c) - mean_direction(coarse(y, x), c);
        energy(y, x)[c] = dot(turn, turn);
        energy(y, x)[3 + c] = 3 * gain * direction_variance(burst, 0.5f * (*fine)(y, x)[4 * c]);
      }
    }
  });
  energy = smooth_along_surface(energy, distance_mm, energy_px, px_mm);
  parallel_for(fine->rows, [&](int y) {
    for (int x = 0; x < fine->cols; ++x) {
      if (std::isnan(distance_mm(y, x))) continue;
      DiffuseMoments& m = (*fine)(y, x);
      for (int c = 0; c < 3; ++c) {
        const float all = energy(y, x)[c], noise = energy(y, x)[3 + c];
        const float kept = all > noise ? 1 - noise / all : 0.f;
        const Vec3 base = mean_direction(coarse(y, x), c);
        const Vec3 direction = base + (mean_direction(m, c) - base) * kept;
        for (int a = 0; a < 3; ++a) m[4 * c + 1 + a] = m[4 * c] * direction[a];
      }
    }
  });
}

}  // namespace

cv::Mat_<DiffuseMoments> diffuse_moments(const Burst& burst, const Image1& distance_mm,
                                         float px_mm) {
  const cv::Mat_<DiffuseMoments> raw = raw_moments(burst, distance_mm);
  const float fine_px = sigma_px(kFineSigmaMm, px_mm, 1.2f, 4.f);
  cv::Mat_<DiffuseMoments> fine = smooth_along_surface(raw, distance_mm, fine_px, px_mm);
  const std::vector<float> fine_taps = gaussian_taps(fine_px);
  const float fine_gain = noise_gain(fine_taps);
  if (noise_of(burst, fine, distance_mm, fine_gain) < kQuietRad) return fine;
  const float coarse_px = sigma_px(kCoarseSigmaMm, px_mm, 2 * fine_px, 20.f);
  const cv::Mat_<DiffuseMoments> coarse = smooth_along_surface(raw, distance_mm, coarse_px, px_mm);
  keep_what_rises_above_noise(burst, coarse, distance_mm,
                              noise_gain(fine_taps, gaussian_taps(coarse_px)), coarse_px, px_mm,
                              &fine);
  return fine;
}

}  // namespace lamella::fit
