#include "fit/mesh_depth.h"

#include <gtest/gtest.h>

#include "fit/geometry.h"
#include "fit/synthetic_rig.h"
#include "io/expect_error.h"

namespace lamella::fit {
namespace {

constexpr float kRadiusMm = 60;

// A degree from each vertex to the next: its triangles sag by 0.003 mm at most.
TriangleMesh sphere_mesh(float radius) {
  constexpr int kAcross = 180, kAround = 360;
  TriangleMesh mesh{"sphere.ply", {}, {}};
  for (int i = 0; i <= kAcross; ++i) {
    for (int j = 0; j < kAround; ++j) {
      const double polar = CV_PI * i / kAcross, azimuth = 2 * CV_PI * j / kAround;
      mesh.vertices_mm.push_back(Vec3(Vec3d(std::sin(polar) * std::cos(azimuth), std::cos(polar),
                                            std::sin(polar) * std::sin(azimuth)) *
                                      double(radius)));
      if (i == 0) continue;
      const int here = i * kAround + j, next = i * kAround + (j + 1) % kAround;
      mesh.triangles.emplace_back(here, next, here - kAround);
      mesh.triangles.emplace_back(next, next - kAround, here - kAround);
    }
  }
  return mesh;
}

TriangleMesh moved(TriangleMesh mesh, const Vec3& by_mm) {
  for (Vec3& v : mesh.vertices_mm) v += by_mm;
  return mesh;
}

TriangleMesh plane_mesh(float z_mm) {
  return {"plane.obj",
          {{-50, -90, z_mm}, {50, -90, z_mm}, {50, 90, z_mm}, {-50, 90, z_mm}},
          {{0, 1, 2}, {0, 2, 3}}};
}

Labels everywhere() { return Labels(testing::kHeight, testing::kWidth, uchar(1)); }

std::string refusal_of(const TriangleMesh& mesh) {
  return lamella::testing::complaint([&] {
    const Session session = testing::make_session();
    const Burst burst = testing::photograph(session, testing::sphere(kRadiusMm));
    mesh_depth(session.left, mesh, burst.regions);
  });
}

TEST(MeshDepth, SeesAPlaneWhereItIsThroughADistortingLens) {
  Session session = testing::make_session();
  session.left.distortion = {-0.3, 0.1, 0.002, -0.001, 0};
  const DepthMap depth = mesh_depth(session.left, plane_mesh(7), everywhere());
  const Vec3d centre = session.left.centre_mm();
  int seen = 0;
  for (int y = 0; y < testing::kHeight; ++y) {
    for (int x = 0; x < testing::kWidth; ++x) {
      const Vec3d ray = session.left.ray(x, y);
      const double mm = (7 - centre[2]) / ray[2];
      const Vec3d at = centre + ray * mm;
      if (std::isnan(depth.distance_mm(y, x))) {
        ASSERT_TRUE(std::abs(at[0]) > 49.9 || std::abs(at[1]) > 89.9) << x << ", " << y;
        continue;
      }
      ASSERT_NEAR(depth.distance_mm(y, x), mm, 0.01);
      ASSERT_EQ(depth.sigma_mm(y, x), kMeshSigmaMm);
      ++seen;
    }
  }
  EXPECT_GT(seen, 5000);
}

TEST(MeshDepth, PutsASphereWhereItIsWithoutAFringe) {
  const Session session = testing::make_session();
  const TriangleMesh mesh = sphere_mesh(kRadiusMm);
  Burst burst = testing::photograph(session, testing::sphere(kRadiusMm));
  burst.fringe.clear();
  burst.right_fringe.clear();
  burst.mesh = &mesh;
  const Geometry geometry = reconstruct_geometry(burst);
  for (int y = 0; y < testing::kHeight; ++y) {
    for (int x = 0; x < testing::kWidth; ++x) {
      if (!burst.regions(y, x)) continue;
      ASSERT_TRUE(is_finite(geometry.position_mm(y, x)));
      if (!geometry.measured(y, x)) continue;
      ASSERT_NEAR(length(geometry.position_mm(y, x)), kRadiusMm, 0.01f) << x << ", " << y;
    }
  }
  EXPECT_GT(cv::countNonZero(geometry.measured), 5000);
}

TEST(MeshDepth, DoesNotMindWhichWayRoundTrianglesAre) {
  TriangleMesh mesh = plane_mesh(7);
  std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
  const Session session = testing::make_session();
  const DepthMap depth = mesh_depth(session.left, mesh, everywhere());
  EXPECT_FALSE(std::isnan(depth.distance_mm(testing::kHeight / 2 + 20, testing::kWidth / 2 + 20)));
  EXPECT_FALSE(std::isnan(depth.distance_mm(testing::kHeight / 2 - 20, testing::kWidth / 2 - 20)));
}

TEST(MeshDepth, RefusesAMeshInOtherUnitsAndSaysHowLargeItIs) {
  for (const float radius : {0.06f, 6.f, 6e4f}) {
    EXPECT_TRUE(lamella::testing::names(
        refusal_of(sphere_mesh(radius)),
        {"sphere.ply: ", "the subject 1000 mm from the left camera", "in millimetres"}))
        << radius;
  }
  EXPECT_TRUE(lamella::testing::names(refusal_of(sphere_mesh(0.06f)), {"0.12 x 0.12 x 0.12 mm"}));
}

TEST(MeshDepth, RefusesAMeshBesideTheSubjectOrFarFromIt) {
  EXPECT_TRUE(lamella::testing::names(
      refusal_of(moved(sphere_mesh(kRadiusMm), {400, 0, 0})),
      {"no triangle of it in the left camera's view", "120 x 120 x 120 mm about (400, 0, 0)"}));
  const Vec3 towards = Vec3(testing::make_session().left.centre_mm()) * 0.7f;
  EXPECT_TRUE(lamella::testing::names(refusal_of(moved(sphere_mesh(kRadiusMm), towards)),
                                      {"sphere.ply: seen by 100.0 %"}));
}

}  // namespace
}  // namespace lamella::fit
