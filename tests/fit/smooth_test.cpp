#include "fit/smooth.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lamella::fit {
namespace {

using Twelve = cv::Vec<float, 12>;
constexpr float kPx_mm = 0.25f;

// A slope with a step in it, a hole, and nothing at all on the left.
Image1 stepped_distance(int rows, int cols) {
  Image1 mm(rows, cols, kNaN);
  for (int y = 0; y < rows; ++y) {
    for (int x = 5; x < cols; ++x) {
      if (std::hypot(x - cols / 2, y - rows / 3) < 4) continue;
      mm(y, x) = 900.f + 0.1f * float(x) + (y > 2 * rows / 3 ? 60.f : 0.f);
    }
  }
  return mm;
}

// Of one line of pixels: the averages of pairs that the surface holds together, one by one.
Twelve averaged(const cv::Mat_<Twelve>& image, const Image1& mm, const cv::Point& p,
                const cv::Point& step, const std::vector<float>& taps) {
  const cv::Rect inside(0, 0, mm.cols, mm.rows);
  Twelve sum = image(p) * taps[0];
  float weight = taps[0];
  for (int k = 1; k < int(taps.size()); ++k) {
    const cv::Point a = p - step * k, b = p + step * k;
    if (!inside.contains(a) || !inside.contains(b)) break;
    const float limit = silhouette_step_mm(k, kPx_mm);
    if (!(std::abs(mm(a) - mm(p)) < limit && std::abs(mm(b) - mm(p)) < limit)) break;
    sum += (image(a) + image(b)) * taps[size_t(k)];
    weight += 2 * taps[size_t(k)];
  }
  return sum * (1 / weight);
}

// More rows than are smoothed at a time, more columns than one run has.
TEST(Smoothing, IsTheAverageOfPairsPixelByPixel) {
  const Image1 mm = stepped_distance(150, 90);
  cv::Mat_<Twelve> image(mm.size());
  cv::RNG random(3);
  for (Twelve& pixel : image) {
    for (int c = 0; c < 12; ++c) pixel[c] = random.uniform(-1.f, 1.f);
  }
  const float width_px = 3.f;
  const std::vector<float> taps = gaussian_taps(width_px);
  const auto smooth = smooth_along_surface(image, span_for(mm, kPx_mm, width_px), width_px);
  cv::Mat_<Twelve> rows(mm.size());
  for (int y = 0; y < mm.rows; ++y) {
    for (int x = 0; x < mm.cols; ++x) {
      if (!std::isnan(mm(y, x))) rows(y, x) = averaged(image, mm, {x, y}, {1, 0}, taps);
    }
  }
  for (int y = 0; y < mm.rows; ++y) {
    for (int x = 0; x < mm.cols; ++x) {
      if (std::isnan(mm(y, x))) continue;
      const Twelve expected = averaged(rows, mm, {x, y}, {0, 1}, taps);
      ASSERT_LT(cv::norm(smooth(y, x) - expected), 1e-5) << x << ", " << y;
    }
  }
}

TEST(SurfaceSpan, EndsAtTheEdgeAtASilhouetteAndOffTheSurface) {
  Image1 mm(3, 21, 1000.f);
  for (int y = 0; y < 3; ++y) {
    for (int x = 15; x < 21; ++x) mm(y, x) = 1100.f;
    mm(y, 0) = kNaN;
  }
  const cv::Mat1b span = SurfaceSpan(mm, kPx_mm, 4).along_row();
  EXPECT_EQ(span(1, 0), SurfaceSpan::kOff);
  EXPECT_EQ(span(1, 3), 2);   // pixel 0 is off the surface
  EXPECT_EQ(span(1, 8), 4);   // as far as is looked
  EXPECT_EQ(span(1, 13), 1);  // the step lies between 14 and 15
  EXPECT_EQ(span(1, 20), 0);  // the picture's edge
}

}  // namespace
}  // namespace lamella::fit
