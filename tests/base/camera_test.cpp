#include "base/camera.h"

#include <gtest/gtest.h>

namespace lamella {
namespace {

Camera test_camera() {
  Camera c;
  c.width = 900;
  c.height = 1100;
  c.fx = 3000;
  c.fy = 3100;
  c.cx = 440;
  c.cy = 560;
  const double s = std::sin(0.3), k = std::cos(0.3);
  c.cam_from_rig = Mat33d(k, 0, -s, 0, -1, 0, -s, 0, -k);
  c.translation_mm = {12, -7, 1000};
  return c;
}

TEST(Camera, SeesItsOwnCentreAtTheOriginOfItsFrame) {
  const Camera c = test_camera();
  EXPECT_LT(cv::norm(c.cam_from_rig * c.centre_mm() + c.translation_mm), 1e-9);
}

TEST(Camera, PutsTheOpticalAxisAtThePrincipalPoint) {
  const Camera c = test_camera();
  const Vec3d axis = c.cam_from_rig.t() * Vec3d(0, 0, 1);
  const cv::Vec2d uv = c.project(c.centre_mm() + axis * 500);
  EXPECT_NEAR(uv[0], c.cx, 1e-9);
  EXPECT_NEAR(uv[1], c.cy, 1e-9);
  EXPECT_NEAR(c.depth_mm(c.centre_mm() + axis * 500), 500, 1e-9);
}

TEST(Camera, ProjectsARayBackToItsPixelWhateverTheDistortion) {
  const std::array<double, 5> lenses[] = {
      {0, 0, 0, 0, 0}, {-0.3, 0.1, 0.001, -0.002, 0.02}, {0.2, -0.05, -0.003, 0.002, 0}};
  for (const auto& lens : lenses) {
    Camera c = test_camera();
    c.distortion = lens;
    for (double u : {0.0, 123.4, 440.0, 899.0}) {
      for (double v : {0.0, 333.3, 1099.0}) {
        const Vec3d ray = c.ray(u, v);
        EXPECT_NEAR(cv::norm(ray), 1, 1e-12);
        const cv::Vec2d uv = c.project(c.centre_mm() + ray * 987.6);
        EXPECT_NEAR(uv[0], u, 1e-6);
        EXPECT_NEAR(uv[1], v, 1e-6);
      }
    }
  }
}

// k1 alone: a point at radius r goes to r (1 + k1 r^2), in units of the focal length.
TEST(Camera, DistortsAsOpenCvDoes) {
  Camera c = test_camera();
  c.fy = c.fx;
  c.distortion = {0.5, 0, 0, 0, 0};
  const Vec3d x = c.centre_mm() + c.cam_from_rig.t() * Vec3d(0.1, 0, 1) * 1000;
  EXPECT_NEAR(c.project(x)[0], c.cx + c.fx * 0.1 * (1 + 0.5 * 0.01), 1e-9);
}

TEST(Camera, ProjectsNothingFromBehind) {
  const Camera c = test_camera();
  const Vec3d behind = c.centre_mm() - c.cam_from_rig.t() * Vec3d(0, 0, 10);
  EXPECT_TRUE(std::isnan(c.project(behind)[0]));
}

TEST(Camera, HasAProjectionMatrixThatAgreesWithIt) {
  const Camera c = test_camera();
  const Vec3d x(20, -30, 40);
  const cv::Vec3d uvw = c.projection() * cv::Vec4d(x[0], x[1], x[2], 1);
  const cv::Vec2d uv = c.project(x);
  EXPECT_NEAR(uvw[0] / uvw[2], uv[0], 1e-9);
  EXPECT_NEAR(uvw[1] / uvw[2], uv[1], 1e-9);
  EXPECT_NEAR(uvw[2], c.depth_mm(x), 1e-9);
}

}  // namespace
}  // namespace lamella
