// Averages along the surface: neighbours in the picture count only where they are neighbours on
// the face.
#pragma once

#include <vector>

#include "base/parallel.h"
#include "base/vec.h"

namespace lamella::fit {

// Weights of a Gaussian, from the middle outwards, cut at 2 sigma; not normalised.
std::vector<float> gaussian_taps(float sigma_px);

// A step between two pixels `px` apart larger than this, mm along the ray, is a silhouette: a
// surface that is seen at 80 degrees falls by 1.4 mm a pixel where a pixel is 0.25 mm.
inline float silhouette_step_mm(int px, float px_mm) { return 6.f * px_mm * float(px); }

namespace detail {

// One pass, along rows (dx = 1) or columns (dy = 1).
template <class Pixel>
void smooth_pass(const Image1& distance_mm, const std::vector<float>& taps, float px_mm, int dx,
                 const cv::Mat_<Pixel>& from, cv::Mat_<Pixel>* to) {
  const int reach = int(taps.size()) - 1;
  parallel_for(from.rows, [&](int y) {
    for (int x = 0; x < from.cols; ++x) {
      const float here = distance_mm(y, x);
      if (std::isnan(here)) continue;
      Pixel sum = from(y, x) * taps[0];
      float weight = taps[0];
      for (int side = -1; side <= 1; side += 2) {
        for (int k = 1; k <= reach; ++k) {
          const int j = dx ? y : y + side * k, i = dx ? x + side * k : x;
          if (i < 0 || j < 0 || i >= from.cols || j >= from.rows) break;
          const float step = std::abs(distance_mm(j, i) - here);
          if (!(step < silhouette_step_mm(k, px_mm))) break;
          sum += from(j, i) * taps[size_t(k)];
          weight += taps[size_t(k)];
        }
      }
      (*to)(y, x) = sum * (1.f / weight);
    }
  });
}

}  // namespace detail

// Gaussian of `sigma_px`, rows and then columns, that stops at silhouettes and at pixels without a
// distance (NaN). `px_mm` is the size of a pixel on the face.
template <class Pixel>
cv::Mat_<Pixel> smooth_along_surface(const cv::Mat_<Pixel>& image, const Image1& distance_mm,
                                     float sigma_px, float px_mm) {
  const std::vector<float> taps = gaussian_taps(sigma_px);
  cv::Mat_<Pixel> rows = image.clone(), both = image.clone();
  detail::smooth_pass(distance_mm, taps, px_mm, 1, image, &rows);
  detail::smooth_pass(distance_mm, taps, px_mm, 0, rows, &both);
  return both;
}

}  // namespace lamella::fit
