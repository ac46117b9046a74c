#include "fit/triangulate.h"

#include <gtest/gtest.h>

#include "fit/synthetic_rig.h"

namespace lamella::fit {
namespace {

TEST(Triangulation, FindsThePointWhoseColumnWasSeen) {
  const Session session = testing::make_session();
  for (const Vec3d& point : {Vec3d(0, 0, 0), Vec3d(40, -60, 30), Vec3d(-55, 20, -25)}) {
    const Vec3d centre = session.left.centre_mm();
    const Ray ray{centre, (point - centre) * (1 / cv::norm(point - centre))};
    const double u = session.projector.project(point)[0];
    const double mm = distance_to_column(ray, session.projector, u);
    EXPECT_NEAR(cv::norm(ray.at(mm) - point), 0, 1e-8);
  }
}

TEST(Triangulation, FollowsTheBentSheetOfADistortedProjector) {
  Session session = testing::make_session();
  session.projector.distortion = {-0.3, 0.1, 0.002, -0.001, 0};
  const Vec3d point(50, 45, 20), centre = session.left.centre_mm();
  const Ray ray{centre, (point - centre) * (1 / cv::norm(point - centre))};
  const double u = session.projector.project(point)[0];
  EXPECT_NEAR(cv::norm(ray.at(distance_to_column(ray, session.projector, u)) - point), 0, 1e-4);
}

TEST(Triangulation, HasNoAnswerWhereTheRayRunsAlongTheSheet) {
  const Session session = testing::make_session();
  const Vec3d centre = session.projector.centre_mm();
  const Ray ray{centre + Vec3d(0, 10, 0), Vec3d(0, 0, -1)};
  EXPECT_TRUE(std::isnan(distance_to_column(ray, session.projector, session.projector.cx)));
}

TEST(Triangulation, ASightingMovesAsThePointDoes) {
  const Session session = testing::make_session();
  const Vec3d point(10, 20, 30), direction = cv::normalize(Vec3d(1, 0, 2));
  const Sighting s = sight(*session.right, point, direction);
  const cv::Vec2d later = session.right->project(point + direction);
  EXPECT_NEAR(cv::norm(s.pixel + s.px_per_mm - later), 0, 2e-3);
}

}  // namespace
}  // namespace lamella::fit
