#include "base/face_surface.h"

#include <gtest/gtest.h>

namespace lamella {
namespace {

constexpr int kSide = 200;

// A slanted plane, a pixel a millimetre, known within a disc.
void plane(Image3* position_mm, Mask* known) {
  *position_mm = Image3(kSide, kSide);
  *known = Mask(kSide, kSide, uchar(0));
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      (*position_mm)(y, x) = {float(x), float(-y), 0.3f * float(x)};
      if (std::hypot(x - kSide / 2, y - kSide / 2) < 80) (*known)(y, x) = 255;
    }
  }
}

float longest_edge(const FaceMesh& mesh) {
  float longest = 0;
  for (const cv::Vec3i& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      longest = std::max(longest, length(mesh.vertices_mm[size_t(t[k])] -
                                         mesh.vertices_mm[size_t(t[(k + 1) % 3])]));
    }
  }
  return longest;
}

TEST(FaceSurface, ClosesANotchAndAHoleButKeepsToItsOutline) {
  Image3 position_mm;
  Mask known;
  plane(&position_mm, &known);
  known(cv::Rect(90, 90, 12, 12)).setTo(0);
  known(cv::Rect(15, 98, 25, 5)).setTo(0);
  const FaceOutline outline = outline_face(position_mm, known);
  const auto inside = [&](int x, int y) {
    return outline.inside_px(y - outline.box.y, x - outline.box.x) > 0;
  };
  EXPECT_TRUE(inside(96, 96));
  EXPECT_TRUE(inside(35, 100));
  EXPECT_FALSE(inside(100, 15));
  EXPECT_FALSE(inside(40, 40));
}

TEST(FaceSurface, IsCutOpenWhereDepthJumpsAcrossIt) {
  Image3 position_mm;
  Mask known;
  plane(&position_mm, &known);
  for (int y = 100; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) position_mm(y, x)[2] -= 60.f;
  }
  const FaceOutline outline = outline_face(position_mm, known);
  const FaceMesh mesh = mesh_face(position_mm(outline.box), outline.inside_px, 3);
  ASSERT_GT(mesh.triangles.size(), 1000u);
  EXPECT_LT(longest_edge(mesh), 20.f);
}

TEST(FaceSurface, DoesNotBelieveSliversBetweenUnknownPixels) {
  Image3 position_mm;
  Mask known;
  plane(&position_mm, &known);
  for (int x = 96; x < 108; x += 3) known(cv::Rect(x, 90, 2, 20)).setTo(0);  // one in three is left
  const FaceOutline outline = outline_face(position_mm, known);
  EXPECT_EQ(outline.torn(100 - outline.box.y, 101 - outline.box.x), 255);
  EXPECT_EQ(outline.torn(100 - outline.box.y, 60 - outline.box.x), 0);
}

TEST(FaceSurface, HasTrianglesThatFaceTheCamera) {
  Image3 position_mm;
  Mask known;
  plane(&position_mm, &known);
  const FaceOutline outline = outline_face(position_mm, known);
  const FaceMesh mesh = mesh_face(position_mm(outline.box), outline.inside_px, 4);
  for (const cv::Vec3i& t : mesh.triangles) {
    const Vec3& a = mesh.vertices_mm[size_t(t[0])];
    const Vec3 n = cross(mesh.vertices_mm[size_t(t[1])] - a, mesh.vertices_mm[size_t(t[2])] - a);
    EXPECT_GT(n[2], -1e-3f);
  }
}

TEST(FaceSurface, OfNothingIsEmpty) {
  EXPECT_TRUE(outline_face(Image3(20, 20, Vec3(0, 0, 0)), Mask(20, 20, uchar(0))).box.empty());
}

}  // namespace
}  // namespace lamella
