#include "fit/unheld.h"

#include <gtest/gtest.h>

namespace lamella::fit {
namespace {

// A face of 40 x 40 pixels in a picture of 60 x 60, measured but for `gap`.
struct Face {
  Labels regions = Labels(60, 60, uchar(0));
  Mask measured = Mask(60, 60, uchar(255));
  explicit Face(const cv::Rect& gap) {
    regions(cv::Rect(10, 10, 40, 40)).setTo(1);
    measured(gap).setTo(0);
  }
  int unheld() const { return cv::countNonZero(unheld_pixels(regions, measured)); }
};

TEST(Unheld, NothingIsWhereEveryPixelWasMeasured) { EXPECT_EQ(Face({}).unheld(), 0); }

TEST(Unheld, ANarrowGapThatIsMeasuredAllAroundIsBridged) {
  EXPECT_EQ(Face({20, 20, 20, 10}).unheld(), 0);
}

TEST(Unheld, OfAWideGapOnlyItsRimIs) {
  EXPECT_EQ(Face({20, 20, 20, 20}).unheld(), 10 * 10);  // farther than 5 pixels from its rim
}

TEST(Unheld, AGapThatIsOpenOnASideIsNotBridged) {
  EXPECT_EQ(Face({45, 10, 5, 40}).unheld(), 5 * 40);   // past the silhouette at the right
  EXPECT_EQ(Face({45, 10, 15, 40}).unheld(), 5 * 40);  // what lies beyond the face is not asked
}

TEST(Unheld, WhatIsMeasuredBehindTheFaceHoldsNothingOfIt) {
  Face face({45, 10, 5, 40});  // the wall beyond x = 50 was measured
  EXPECT_EQ(face.unheld(), 5 * 40);
  face.measured.setTo(0);
  EXPECT_EQ(face.unheld(), 40 * 40);
}

TEST(Unheld, AtTheEdgeOfThePictureAGapIsOpen) {
  Face face({0, 20, 3, 10});
  face.regions.setTo(1);
  EXPECT_EQ(face.unheld(), 3 * 10);
}

}  // namespace
}  // namespace lamella::fit
