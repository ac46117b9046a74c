// Averages along the surface: neighbours in the picture count only where they are neighbours on
// the face.
#pragma once

#include <algorithm>
#include <vector>

#include "base/parallel.h"
#include "base/vec.h"

namespace lamella::fit {

// Weights of a Gaussian, from the middle outwards, cut at 2 sigma; not normalised.
std::vector<float> gaussian_taps(float sigma_px);

// What is left of white noise of variance 1, in two dimensions, after an average, and after a fine
// one less a coarse one.
float noise_gain(const std::vector<float>& taps);
float noise_gain(const std::vector<float>& fine, const std::vector<float>& coarse);

// Averages are as wide as the skin asks for (mm), and at least and at most so many pixels.
inline float sigma_px(float sigma_mm, float px_mm, float least_px, float most_px) {
  return std::clamp(sigma_mm / px_mm, least_px, most_px);
}

// A step between two pixels `px` apart larger than this, mm along the ray, is a silhouette: a
// surface that is seen at 80 degrees falls by 5.7 pixels' width a pixel.
inline float silhouette_step_mm(int px, float px_mm) { return 6.f * px_mm * float(px); }

namespace detail {

// One pass, along rows (dx = 1) or columns (dx = 0). Neighbours count in pairs, one on either
// side, so that what changes linearly stays as it is up to the very edge.
template <class Pixel>
void smooth_pass(const Image1& distance_mm, const std::vector<float>& taps, float px_mm, int dx,
                 const cv::Mat_<Pixel>& from, cv::Mat_<Pixel>* to) {
  const int reach = int(taps.size()) - 1, dy = 1 - dx;
  parallel_for(from.rows, [&](int y) {
    for (int x = 0; x < from.cols; ++x) {
      const float here = distance_mm(y, x);
      if (std::isnan(here)) continue;
      const int room = dx ? std::min(x, from.cols - 1 - x) : std::min(y, from.rows - 1 - y);
      Pixel sum = from(y, x) * taps[0];
      float weight = taps[0];
      for (int k = 1; k <= std::min(reach, room); ++k) {
        const int j = k * dy, i = k * dx;
        const float limit = silhouette_step_mm(k, px_mm);
        if (!(std::abs(distance_mm(y - j, x - i) - here) < limit) ||
            !(std::abs(distance_mm(y + j, x + i) - here) < limit)) {
          break;
        }
        sum += (from(y - j, x - i) + from(y + j, x + i)) * taps[size_t(k)];
        weight += 2 * taps[size_t(k)];
      }
      (*to)(y, x) = sum * (1.f / weight);
    }
  });
}

}  // namespace detail

// Gaussian of sigma `width_px`, rows and then columns, that stops at silhouettes and at pixels
// without a distance (NaN), and leaves those undefined. `px_mm` is the size of a pixel on the face.
template <class Pixel>
cv::Mat_<Pixel> smooth_along_surface(const cv::Mat_<Pixel>& image, const Image1& distance_mm,
                                     float width_px, float px_mm) {
  const std::vector<float> taps = gaussian_taps(width_px);
  cv::Mat_<Pixel> rows(image.size()), both(image.size());
  detail::smooth_pass(distance_mm, taps, px_mm, 1, image, &rows);
  detail::smooth_pass(distance_mm, taps, px_mm, 0, rows, &both);
  return both;
}

}  // namespace lamella::fit
