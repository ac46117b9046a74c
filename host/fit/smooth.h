// Averages along the surface: neighbours in the picture count only where they are neighbours on
// the face.
#pragma once

#include <algorithm>
#include <vector>

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

// How many pixels the surface goes on, on both sides of each pixel alike: along the row, and along
// the column.
class SurfaceSpan {
 public:
  static constexpr uchar kOff = 255;  // no surface there

  // `distance_mm`: along the ray, NaN off the surface. `px_mm`: size of a pixel on the face. Looks
  // `most_px` far, 254 at most.
  SurfaceSpan(const Image1& distance_mm, float px_mm, int most_px);

  const cv::Mat1b& along_row() const { return along_row_; }
  const cv::Mat1b& along_column() const { return along_column_; }

 private:
  cv::Mat1b along_row_, along_column_;
};

// Wide enough for averages of `width_px`.
SurfaceSpan span_for(const Image1& distance_mm, float px_mm, float width_px);

namespace detail {
inline constexpr int kMostChannels = 12;
void smooth_floats(const cv::Mat& image, const SurfaceSpan& span, float width_px, cv::Mat* to);
}  // namespace detail

// Gaussian of sigma `width_px`, rows and then columns, that stops at silhouettes and at pixels off
// the surface, and leaves those undefined. Neighbours count in pairs, one on either side, so that
// what changes linearly stays as it is up to the very edge.
template <class Pixel>
cv::Mat_<Pixel> smooth_along_surface(const cv::Mat_<Pixel>& image, const SurfaceSpan& span,
                                     float width_px) {
  static_assert(cv::DataType<Pixel>::channels <= detail::kMostChannels);
  cv::Mat_<Pixel> smooth(image.size());
  detail::smooth_floats(image, span, width_px, &smooth);
  return smooth;
}

}  // namespace lamella::fit
