#include "base/ray_scene.h"

#include <gtest/gtest.h>

namespace lamella {
namespace {

RayScene one_triangle() { return RayScene({{0, 0, 0}, {10, 0, 0}, {0, 10, 0}}, {{0, 1, 2}}); }

TEST(RayScene, HitsATriangleWhereItIs) {
  const Hit hit = one_triangle().intersect({2, 3, 50}, {0, 0, -1}, 0, 1e9f);
  EXPECT_FLOAT_EQ(hit.distance_mm, 50);
  EXPECT_EQ(hit.triangle, 0);
  EXPECT_NEAR(hit.u, 0.2, 1e-6);
  EXPECT_NEAR(hit.v, 0.3, 1e-6);
}

TEST(RayScene, MissesBesideAndBeyondTheEndOfTheRay) {
  const RayScene scene = one_triangle();
  EXPECT_LT(scene.intersect({9, 9, 50}, {0, 0, -1}, 0, 1e9f).distance_mm, 0);
  EXPECT_FALSE(scene.occluded({2, 3, 50}, {0, 0, -1}, 0, 49));
  EXPECT_TRUE(scene.occluded({2, 3, 50}, {0, 0, -1}, 0, 51));
}

TEST(RayScene, KeepsARayOffTheSurfaceItLeaves) {
  EXPECT_FALSE(one_triangle().occluded({2, 3, 0}, {0, 0, 1}, 0.01f, 1e9f));
}

TEST(RayScene, OfNothingIsNeverHit) {
  EXPECT_FALSE(RayScene({}, {}).occluded({0, 0, 0}, {0, 0, 1}, 0, 1e9f));
}

}  // namespace
}  // namespace lamella
