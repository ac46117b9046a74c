// The figures behind a session's check. All are over labelled pixels of the left camera, in
// radiance units of the session.
#pragma once

#include <array>
#include <vector>

#include "io/session.h"

namespace lamella {

// The left camera's photographs that the figures need.
struct CheckedBurst {
  Photograph full_parallel, full_cross;    // GRADIENT_FULL
  std::array<Photograph, 3> gradient;      // GRADIENT_X, _Y, _Z cross
  Photograph front_parallel, front_cross;  // FRONT
  Photograph black;                        // BLACK
  Photograph finest_fringe;                // FRINGE of the highest index
  std::array<Photograph, 4> stripes;
  std::vector<cv::Point> pixels;        // labelled, at most 20000 of them
  std::vector<cv::Point> right_pixels;  // of the right camera; empty without its geometry
};

// Labelled pixels; where the session has no labels, those that FRONT cross lights well.
std::vector<cv::Point> pixels_to_check(const Labels& labels, const Image3& front_cross);

// Mean radiance over pixels, per channel.
Vec3 mean_light(const Photograph& photograph, const std::vector<cv::Point>& pixels);

// Share of pixels clipped in any of them.
double clipped_share(const std::vector<const Photograph*>& photographs,
                     const std::vector<cv::Point>& pixels);

// Median over pixels of radiance / sigma of the camera's noise, in the channel where it is least:
// sigma^2 = read_noise^2 + quantisation^2 + stored * saturation / full_well_electrons.
// 0 where the manifest says nothing of the noise.
double signal_to_noise(const Photograph& photograph, const Camera& camera, const Frame& frame,
                       const std::vector<cv::Point>& pixels);

// Median of BLACK / FRONT cross: the projector's black level b.
double black_level(const CheckedBurst& burst);

// The four stripe patterns add up to twice white and twice black: median of
// |sum of STRIPES / (2 (FRONT + BLACK)) - 1|.
double stripe_closure(const CheckedBurst& burst);

// Mean of S = parallel - cross over mean of cross. Negative: the analysers are the wrong way round.
double polarized_share(const Photograph& parallel, const Photograph& cross,
                       const std::vector<cv::Point>& pixels);

// Median of the modulation of the finest fringe, relative to white light: 1 where it is as drawn.
double fringe_contrast(const CheckedBurst& burst);

// Share of pixels where a gradient frame is brighter than the full one by more than a tenth: no
// level of its is above 1.
double gradient_above_full(const CheckedBurst& burst);

}  // namespace lamella
