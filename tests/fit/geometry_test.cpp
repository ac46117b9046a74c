#include "fit/geometry.h"

#include <gtest/gtest.h>

#include "fit/depth_fill.h"
#include "fit/synthetic_rig.h"

namespace lamella::fit {
namespace {

using testing::Shape;

// Distances (mm) of the answered positions from where the shape really is; `missing` counts the
// labelled pixels without an answer.
std::vector<float> errors_mm(const Burst& burst, const Geometry& geometry, const Shape& shape,
                             int* missing = nullptr) {
  std::vector<float> errors;
  const Camera& left = burst.session->left;
  for (int y = 0; y < burst.regions.rows; ++y) {
    for (int x = 0; x < burst.regions.cols; ++x) {
      if (!burst.regions(y, x)) continue;
      const Vec3& p = geometry.position_mm(y, x);
      if (is_finite(p)) {
        const auto truth = shape(left.centre_mm(), left.ray(x, y));
        errors.push_back(float(cv::norm(Vec3d(p) - truth->position_mm)));
      } else if (missing) {
        ++*missing;
      }
    }
  }
  return errors;
}

TEST(Geometry, PutsASphereWhereItIs) {
  const Session session = testing::make_session();
  const Shape shape = testing::sphere(60);
  const Burst burst = testing::photograph(session, shape);
  int missing = 0;
  const auto errors = errors_mm(burst, reconstruct_geometry(burst), shape, &missing);
  EXPECT_EQ(missing, 0);
  EXPECT_LT(testing::quantile(errors, 0.5), 0.05f);
  EXPECT_LT(testing::quantile(errors, 0.9), 0.3f);
}

TEST(Geometry, TakesNothingFromFringesThatAreClipped) {
  const Session session = testing::make_session();
  const Shape shape = testing::sphere(60);
  Burst burst = testing::photograph(session, shape);
  const cv::Rect left(60, 90, 6, 6), right(80, 90, 40, 40);
  burst.clipped_fringe = burst.clipped_right = Mask(burst.regions.size(), 0);
  burst.clipped_fringe(left).setTo(255);
  burst.clipped_right(right).setTo(255);
  burst.fringe.back() = burst.fringe.back().clone();
  burst.fringe.back()(left) *= 0.5;
  burst.right_fringe.back() = burst.right_fringe.back().clone();
  burst.right_fringe.back()(right).setTo(cv::Scalar(.2, .15, .05));
  const Geometry geometry = reconstruct_geometry(burst);
  EXPECT_GT(cv::mean(geometry.sigma_mm(left))[0], 0.3);
  const auto errors = errors_mm(burst, geometry, shape);
  EXPECT_LT(testing::quantile(errors, 0.5), 0.06f);
  EXPECT_LT(testing::quantile(errors, 0.9), 0.35f);
}

TEST(Geometry, NeedsNoRightCamera) {
  Session session = testing::make_session();
  session.right.reset();
  const Shape shape = testing::sphere(60);
  const Burst burst = testing::photograph(session, shape);
  int missing = 0;
  const auto errors = errors_mm(burst, reconstruct_geometry(burst), shape, &missing);
  EXPECT_EQ(missing, 0);
  EXPECT_LT(testing::quantile(errors, 0.5), 0.1f);
}

TEST(Geometry, IsLessSureWhereOneCameraAloneSpeaks) {
  Session session = testing::make_session();
  const Shape shape = testing::sphere(60);
  const Geometry pair = reconstruct_geometry(testing::photograph(session, shape));
  session.right.reset();
  const Geometry alone = reconstruct_geometry(testing::photograph(session, shape));
  EXPECT_LT(pair.sigma_mm(100, 80), 0.05f);
  EXPECT_GT(alone.sigma_mm(100, 80), 0.1f);  // the photographs are free of noise, phases of no bias
}

TEST(Geometry, TurnsWithTheRig) {
  Session session = testing::make_session(), turned_session = testing::make_session();
  const Mat33d turn(0.36, 0.48, -0.8, -0.8, 0.6, 0, 0.48, 0.64, 0.6);
  testing::rotate_rig(turn, &turned_session);
  const Shape shape = testing::sphere(60);
  const Geometry straight = reconstruct_geometry(testing::photograph(session, shape));
  const Geometry turned = reconstruct_geometry(testing::photograph(turned_session, shape));
  const cv::Matx33f r(turn);
  std::vector<float> apart;
  for (int y = 0; y < straight.position_mm.rows; ++y) {
    for (int x = 0; x < straight.position_mm.cols; ++x) {
      const Vec3 d = r * straight.position_mm(y, x) - turned.position_mm(y, x);
      if (is_finite(d)) apart.push_back(length(d));
    }
  }
  ASSERT_GT(apart.size(), 3000u);
  EXPECT_LT(testing::quantile(apart, 0.99), 0.01f);
}

TEST(Geometry, DoesNotBridgeASilhouette) {
  const Session session = testing::make_session();
  const Shape shape = testing::stepped_plane(40, 0);
  const Burst burst = testing::photograph(session, shape);
  const Geometry geometry = reconstruct_geometry(burst);
  int between = 0;
  for (const Vec3& p : geometry.position_mm) between += p[2] > 3 && p[2] < 37;
  EXPECT_EQ(between, 0);
}

TEST(Geometry, SaysHowSureItIs) {
  const Session session = testing::make_session();
  const Burst burst = testing::photograph(session, testing::sphere(60));
  const Geometry geometry = reconstruct_geometry(burst);
  for (int y = 0; y < burst.regions.rows; ++y) {
    for (int x = 0; x < burst.regions.cols; ++x) {
      if (!burst.regions(y, x)) continue;
      ASSERT_GT(geometry.sigma_mm(y, x), 0);
      if (burst.front_lit(y, x)[0] <= 0) {
        ASSERT_GT(geometry.sigma_mm(y, x), 0.3f);
      }
    }
  }
}

TEST(Geometry, AnswersOnlyWhereThereIsARegion) {
  const Session session = testing::make_session();
  Burst burst = testing::photograph(session, testing::sphere(60));
  burst.regions(cv::Rect(60, 80, 20, 20)).setTo(0);
  const Geometry geometry = reconstruct_geometry(burst);
  EXPECT_FALSE(is_finite(geometry.position_mm(90, 70)));
  EXPECT_TRUE(is_finite(geometry.scene_mm(90, 70)));
}

TEST(DepthFill, CarriesAPlaneOverAGap) {
  const Session session = testing::make_session();
  const Vec3 normal = unit(Vec3(.3f, .2f, 1));
  const cv::Size size(testing::kWidth, testing::kHeight);
  DepthMap depth{Image1(size), Image1(size, .02f), Image1(size, 0.f), 1.25f};
  const auto true_mm = [&](int y, int x) {
    return -dot(normal, Vec3(session.left.centre_mm())) / dot(normal, Vec3(session.left.ray(x, y)));
  };
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) depth.distance_mm(y, x) = true_mm(y, x);
  }
  depth.distance_mm(cv::Rect(70, 80, 12, 12)).setTo(kNaN);
  fill_depth(session.left, Mask(size, uchar(255)), Image3(size, normal), &depth);
  EXPECT_NEAR(depth.distance_mm(86, 76), true_mm(86, 76), 0.05f);
  EXPECT_GT(depth.sigma_mm(86, 76), depth.sigma_mm(80, 76));
  EXPECT_GT(depth.sigma_mm(80, 76), depth.sigma_mm(20, 20));
}

}  // namespace
}  // namespace lamella::fit
