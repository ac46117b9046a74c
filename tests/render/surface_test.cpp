#include "render/surface.h"

#include <gtest/gtest.h>

#include "render/completion.h"
#include "render/scene.h"

namespace lamella::render {
namespace {

// A plane whose measured depth ripples by `amplitude_mm`, as fringes out of step make it.
LayerMaps rippled_plane(float amplitude_mm) {
  Skin skin;
  skin.deep = skin.shallow = Vec3::all(0.3f);
  LayerMaps maps = plane(front_camera(120, 0.5), skin).maps;
  for (int i = 0; i < 120; ++i) {
    for (int j = 0; j < 120; ++j) {
      maps.position_mm(i, j)[2] += amplitude_mm * std::sin(float(j) * 0.55f);
    }
  }
  return maps;
}

TEST(PositionNoise, IsWhatRipplesAreAndNotWhatCurvatureIs) {
  EXPECT_LT(position_noise_mm(sphere(front_camera(150, 0.25), 60, Skin()).maps), 0.05);
  EXPECT_NEAR(position_noise_mm(rippled_plane(0.3f)), 0.3, 0.2);
}

TEST(Shadows, AreNotCastByTheNoiseOfTheMeasuredSurface) {
  const Surface surface = build_surface(complete_maps(rippled_plane(0.3f)), 1);
  const Vec3 low_light = unit(Vec3(1, 0, 0.35f));
  int dark = 0;
  for (size_t v = 0; v < surface.normal.size(); ++v) {
    dark += shaded(surface, surface.mesh.vertices_mm[v], surface.normal[v], low_light, 1e4f);
  }
  EXPECT_LT(dark, int(surface.normal.size()) / 50);
}

TEST(Trace, GivesThePixelOfTheMapThatARayMeets) {
  const Camera camera = front_camera(60, 1);
  const Surface surface = build_surface(complete_maps(plane(camera, Skin()).maps), 2);
  const SurfacePoint point = trace(surface, Vec3(camera.centre_mm()), Vec3(camera.ray(21.3, 40.6)));
  ASSERT_TRUE(point.on_surface());
  EXPECT_NEAR(point.pixel[0], 21.3, 0.01);
  EXPECT_NEAR(point.pixel[1], 40.6, 0.01);
}

TEST(Mesh, IsJoinedAcrossANarrowStepAndOpenAcrossAWideOne) {
  const auto step_of = [](float depth_mm) {
    LayerMaps maps = rippled_plane(0);
    for (int i = 0; i < 120; ++i) {
      for (int j = 60; j < 120; ++j) maps.position_mm(i, j)[2] -= depth_mm;
    }
    const Surface surface = build_surface(complete_maps(maps), 1);
    return surface.rays.occluded({0.25f, 3.1f, -5}, {-1, 0, 0}, 0, 2);
  };
  EXPECT_TRUE(step_of(25));  // beside a nose
  EXPECT_FALSE(step_of(60));
}

}  // namespace
}  // namespace lamella::render
