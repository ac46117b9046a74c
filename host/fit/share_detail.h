// What noise is in the shallow share of every pixel, and what skin: noise differs from channel to
// channel, a mole does not.
#pragma once

#include "base/vec.h"

namespace lamella::fit {

// Shares of the stripes, per pixel and channel, and the variance that the camera's noise alone
// gives them; NaN where there is no pixel.
struct ShareMap {
  Image3 share;
  Image3 noise_variance;
};

// In place: each pixel's share is its neighbourhood's mean, of its own region within `window_px`
// pixels, plus as much of what it differs by as is not noise: with C the region's covariance of
// those differences and N the noise's, G = (C - N) C^-1 of them (Wiener, across the channels).
// `noise_variance` becomes the variance of the share's error, the diagonal of G N, in which what
// was taken for noise and was skin has its part, and N/n with n pixels in the mean. Without noise
// nothing changes.
void remove_share_noise(const Labels& regions, int region_count, int window_px, ShareMap* map);

}  // namespace lamella::fit
