// Two pictures of the same thing.
#pragma once

#include "apps/compare_statistics.h"
#include "io/exr.h"

namespace lamella::apps {

// Over the pixels of `mask` (empty: all) of `found` against `truth`: rel_rmse,
// rel_rmse_best_scale, best_scale, psnr_srgb_db (display values, white at the 99th percentile of
// the truth), mean_ratio_rgb, nonfinite, black. Values that are not finite count as 0.
Json image_figures(const Image3& found, const Image3& truth, const Mask& mask);

// The relative RMSE alone.
double relative_rmse(const Image3& found, const Image3& truth, const Mask& mask);

// 255 where a PNG of labels or a mask, grey or in colour, is not 0 (black). Throws Error where it
// cannot be read or is of another size.
Mask read_mask(const fs::path& file, const cv::Size& size);

}  // namespace lamella::apps
