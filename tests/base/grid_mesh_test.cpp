#include "base/grid_mesh.h"

#include <gtest/gtest.h>

namespace lamella {
namespace {

// A plane facing +Z, rows downwards as in a photograph, one millimetre a pixel.
Image3 plane(int rows, int cols) {
  Image3 position_mm(rows, cols);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < cols; ++x) position_mm(y, x) = Vec3(float(x), float(-y), 0);
  }
  return position_mm;
}

TEST(GridMesh, MakesTwoTrianglesAQuadThatFaceTheCamera) {
  const GridMesh mesh = mesh_from_positions(plane(4, 5), 1, 2.f);
  ASSERT_EQ(mesh.vertices_mm.size(), 20u);
  ASSERT_EQ(mesh.triangles.size(), 2u * 3 * 4);
  for (const cv::Vec3i& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices_mm[size_t(t[0])], &b = mesh.vertices_mm[size_t(t[1])],
               &c = mesh.vertices_mm[size_t(t[2])];
    EXPECT_GT(cross(b - a, c - a)[2], 0.f);
  }
}

TEST(GridMesh, LeavesSilhouettesAndHolesOpen) {
  Image3 position_mm = plane(4, 5);
  position_mm(0, 0) = Vec3(kNaN, kNaN, kNaN);
  EXPECT_EQ(mesh_from_positions(position_mm, 1, 2.f).triangles.size(), 2u * 3 * 4 - 2);
  for (int y = 0; y < 4; ++y) position_mm(y, 4)[2] = -50;  // another surface, far behind
  EXPECT_EQ(mesh_from_positions(position_mm, 1, 2.f).triangles.size(), 2u * 3 * 3 - 2);
}

TEST(GridMesh, RemembersThePixelOfEveryVertex) {
  const GridMesh mesh = mesh_from_positions(plane(5, 7), 2, 4.f);
  ASSERT_EQ(mesh.vertices_mm.size(), 3u * 4);
  EXPECT_EQ(mesh.pixel.back(), cv::Point(6, 4));
  EXPECT_EQ(mesh.vertices_mm.back(), Vec3(6, -4, 0));
}

}  // namespace
}  // namespace lamella
