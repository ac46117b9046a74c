#include "fit/pattern_place.h"

#include <gtest/gtest.h>

#include "lit_plane.h"

namespace lamella::fit {
namespace {

const Vec3d kMovedMm(0.3, -0.2, 0.1);

TEST(PatternPlace, OfASubjectAtRestIsTheVeryMapThatWasGiven) {
  const Image2 map(4, 5, Vec2(3, 4));
  EXPECT_EQ(moved_projector_px(map, {}).data, map.data);
}

TEST(PatternPlace, OfAMovedPointIsWhatLightsItWhereItIs) {
  const Camera projector = testing::make_session().projector;
  const Vec3d place(12, -30, 20);
  const cv::Vec2d there = projector.project(place + kMovedMm);
  EXPECT_LT(cv::norm(projector_seen_by_moved(projector, kMovedMm).project(place) - there), 1e-9);
  const Vec2 moved = pattern_moved_px(projector, kMovedMm);
  EXPECT_LT(cv::norm(cv::Vec2d(moved) - (there - projector.project(place))), 0.05);
}

TEST(PatternPlace, FollowsTheSurfaceByAFractionOfAPixel) {
  testing::LitPlane plane = testing::make_plane(Vec3(.3f, .2f, .15f), 2100);
  const Image2& map = plane.geometry.projector_px;
  const Image2 found = moved_projector_px(map, {{0, 0}, {0.4f, -0.3f}});
  const int y = 100, x = 80;
  const Vec2 expected =
      map(y, x) - (map(y, x + 1) - map(y, x - 1)) * 0.2f + (map(y + 1, x) - map(y - 1, x)) * 0.15f;
  EXPECT_LT(cv::norm(found(y, x) - expected), 1e-3);
  EXPECT_GT(cv::norm(found(y, x) - map(y, x)), 0.1);
}

}  // namespace
}  // namespace lamella::fit
