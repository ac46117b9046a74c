// Sums over a square around every pixel, by all cores.
#pragma once

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "base/parallel.h"

namespace lamella::fit {

// `width_px` odd; mirrored beyond the edge. `Image`: of cv::Mat_, of floats. Bands of rows side by
// side, each of which sees the rows beyond it.
template <class Image>
Image box_sums(const Image& image, int width_px) {
  const int band = std::max(64, width_px);
  Image sums(image.size());
  parallel_for((image.rows + band - 1) / band, [&](int i) {
    const cv::Range rows(i * band, std::min(image.rows, (i + 1) * band));
    Image to = sums.rowRange(rows);
    cv::boxFilter(image.rowRange(rows), to, -1, {width_px, width_px}, {-1, -1}, false);
  });
  return sums;
}

}  // namespace lamella::fit
