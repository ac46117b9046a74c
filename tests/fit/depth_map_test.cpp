#include "fit/depth_map.h"

#include <gtest/gtest.h>

#include <functional>

#include "fit/synthetic_rig.h"

namespace lamella::fit {
namespace {

// What the left camera measures of a surface that lies `away_mm(y, x)` further than the origin.
class MeasureDepth : public ::testing::Test {
 protected:
  using Surface = std::function<float(int y, int x)>;

  ProjectorColumns columns_of(const Surface& away_mm) const {
    ProjectorColumns columns{Image1(testing::kHeight, testing::kWidth),
                             Image1(testing::kHeight, testing::kWidth, 0.01f)};
    for (int y = 0; y < testing::kHeight; ++y) {
      for (int x = 0; x < testing::kWidth; ++x) {
        const Vec3d point =
            session_.left.centre_mm() + session_.left.ray(x, y) * double(kOriginMm + away_mm(y, x));
        columns.u_px(y, x) = float(session_.projector.project(point)[0]);
      }
    }
    return columns;
  }

  DepthMap measure(const ProjectorColumns& columns) const {
    return measure_depth(session_.left, session_.projector, columns);
  }

  static constexpr float kOriginMm = 1000, kPixelWidthMm = 1.25f;
  const Session session_ = testing::make_session();
};

TEST_F(MeasureDepth, KeepsTheCornersOfAnOutline) {
  const cv::Rect near(60, 80, 40, 40);
  const DepthMap depth = measure(
      columns_of([&](int y, int x) { return near.contains(cv::Point(x, y)) ? -40.f : 0.f; }));
  EXPECT_NEAR(depth.distance_mm(80, 60), kOriginMm - 40, 0.1f);
  EXPECT_NEAR(depth.distance_mm(119, 99), kOriginMm - 40, 0.1f);
}

TEST_F(MeasureDepth, KeepsAFlankThatFallsSteeplyBeforeASilhouette) {
  constexpr float kStepMm = 15 * kPixelWidthMm;
  const DepthMap depth = measure(columns_of([&](int, int x) {
    return x < 80 ? -80.f : x < 83 ? -80 + kStepMm * float(x - 79) : 40.f;
  }));
  for (int x = 80; x < 83; ++x) {
    EXPECT_NEAR(depth.distance_mm(100, x), kOriginMm - 80 + kStepMm * float(x - 79), 0.1f) << x;
  }
}

TEST_F(MeasureDepth, KeepsAFlankThatIsSmall) {
  constexpr float kStepMm = 9 * kPixelWidthMm;
  const cv::Rect flank(60, 80, 3, 20);
  const DepthMap depth = measure(columns_of([&](int y, int x) {
    if (flank.contains(cv::Point(x, y))) return -80 + kStepMm * float(x - 59);
    return x < 60 ? -80.f : 20.f;
  }));
  EXPECT_NEAR(depth.distance_mm(90, 62), kOriginMm - 80 + 3 * kStepMm, 0.1f);
}

TEST_F(MeasureDepth, DropsAPatchWhosePhaseIsATurnOff) {
  ProjectorColumns columns = columns_of([](int, int) { return 0.f; });
  columns.u_px(100, 30) += 20;
  columns.u_px(cv::Rect(70, 90, 6, 6)) += cv::Scalar(20);
  const DepthMap depth = measure(columns);
  EXPECT_TRUE(std::isnan(depth.distance_mm(100, 30)));
  EXPECT_TRUE(std::isnan(depth.distance_mm(93, 73)));
  EXPECT_NEAR(depth.distance_mm(100, 73), kOriginMm, 0.1f);
}

}  // namespace
}  // namespace lamella::fit
