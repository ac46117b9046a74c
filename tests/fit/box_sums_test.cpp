#include "fit/box_sums.h"

#include <gtest/gtest.h>

#include "base/vec.h"

namespace lamella::fit {
namespace {

// Failure: a seam wherever a band ends.
TEST(BoxSums, AreThoseOfTheWholeImageOverEveryBand) {
  Image3 image(150, 40);
  cv::randu(image, 0.f, 1.f);
  for (const int width_px : {1, 7, 91}) {
    Image3 whole;
    cv::boxFilter(image, whole, -1, {width_px, width_px}, {-1, -1}, false);
    const double most = cv::norm(whole, cv::NORM_INF);
    EXPECT_LT(cv::norm(box_sums(image, width_px), whole, cv::NORM_INF), 1e-5 * most) << width_px;
  }
}

}  // namespace
}  // namespace lamella::fit
