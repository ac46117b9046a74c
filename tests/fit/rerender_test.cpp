#include "fit/rerender.h"

#include <gtest/gtest.h>

#include "fit/synthetic_sphere.h"

namespace lamella::fit {
namespace {

struct Layers {
  SyntheticSphere sphere;
  SpecularFit specular;
  Separation separation;
  Albedo albedo;

  RerenderResiduals residuals() const {
    return rerender(sphere.burst, {sphere.geometry, sphere.normals, specular, separation, albedo});
  }
};

// A noise-free sphere with its layers as they are.
void make_layers(Layers* layers) {
  layers->sphere = SpherePhotographer().photograph(
      {SyntheticSkin{}}, [](float, float) { return 1; }, false);
  settle(&layers->sphere);
  const SyntheticSphere& s = layers->sphere;
  const cv::Size size = s.burst.regions.size();
  layers->specular.polarized_front = polarized(s.burst.front);
  layers->specular.polarized_full = polarized(s.burst.full);
  layers->specular.intensity_confidence = Image1(size, 1.f);
  const float half = SpherePhotographer::kAlbedo / 2;
  layers->separation.shallow_albedo = Image3(size, Vec3(half, half, half));
  layers->separation.deep_albedo = layers->separation.shallow_albedo.clone();
  layers->separation.confidence = Image1(size, 1.f);
  layers->albedo.total = layers->separation.shallow_albedo * 2;
  layers->albedo.confidence = Image1(size, 1.f);
}

TEST(Rerender, OfTheTrueLayersLeavesNothing) {
  Layers layers;
  make_layers(&layers);
  const RerenderResiduals r = layers.residuals();
  EXPECT_LT(r.front_parallel, 0.005);
  EXPECT_LT(r.front_cross, 0.005);
  EXPECT_LT(r.full_parallel, 0.005);
  EXPECT_LT(r.full_cross, 0.005);
}

TEST(Rerender, ShowsALayerThatIsTenPercentOff) {
  Layers layers;
  make_layers(&layers);
  layers.albedo.total *= 1.1;
  EXPECT_NEAR(layers.residuals().full_cross, 0.1, 0.01);
  EXPECT_LT(layers.residuals().front_cross, 0.005);
}

TEST(Rerender, LooksOnlyWhereTheMapsAreConfidentAndNothingIsClipped) {
  Layers layers;
  make_layers(&layers);
  const cv::Rect half(0, 0, SpherePhotographer::kSize / 2, SpherePhotographer::kSize);
  layers.specular.polarized_front(half).setTo(cv::Scalar::all(9));
  layers.sphere.burst.clipped_projector(half).setTo(255);
  EXPECT_LT(layers.residuals().front_parallel, 0.005);
  layers.specular.intensity_confidence.setTo(0);
  EXPECT_TRUE(std::isnan(layers.residuals().front_parallel));
}

}  // namespace
}  // namespace lamella::fit
