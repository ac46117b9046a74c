#include "export/for_view.h"

#include <gtest/gtest.h>

#include "base/error.h"

namespace lamella::exporting {
namespace {

constexpr int kSide = 200;

// A square of 100 mm that faces +Z, half a millimetre a pixel.
LayerMaps square() {
  LayerMaps maps;
  maps.position_mm = Image3(kSide, kSide);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      maps.position_mm(y, x) = {0.5f * float(x - 100), 0.5f * float(100 - y), 0};
    }
  }
  return maps;
}

v1::Layers skin() {
  v1::Layers layers;
  v1::Region& region = *layers.add_regions();
  for (double ld_mm : {2.0, 1.0, 0.7}) region.mutable_deep()->add_ld_mm(ld_mm);
  for (double ld_mm : {3.0, 2.0, 1.0}) region.mutable_shallow()->add_ld_mm(ld_mm);
  region.mutable_shallow()->set_thickness_mm(0.6);
  return layers;
}

// On +Z at a metre, with `px_per_mm` there.
View view_with(double px_per_mm) {
  View view;
  view.camera.width = view.camera.height = 1000;
  view.camera.fx = view.camera.fy = 1000 * px_per_mm;
  view.camera.cx = view.camera.cy = 499.5;
  view.camera.cam_from_rig = Mat33d(1, 0, 0, 0, -1, 0, 0, 0, -1);
  view.camera.translation_mm = {0, 0, 1000};
  return view;
}

TEST(ForView, MeasuresTheFaceInPixels) {
  const ViewChoice c = choose_for_view(square(), skin(), view_with(1), "view");
  EXPECT_NEAR(c.face_px.width, 100, 1);
  EXPECT_NEAR(c.px_per_mm, 1, 0.01);
}

TEST(ForView, TakesATexelAPixelAndNoMoreThanWasMeasured) {
  EXPECT_NEAR(choose_for_view(square(), skin(), view_with(1), "view").texture_side_px, 100, 2);
  EXPECT_NEAR(choose_for_view(square(), skin(), view_with(9), "view").texture_side_px, 200, 1);
}

TEST(ForView, TakesTrianglesOfAFewPixels) {
  const int near = choose_for_view(square(), skin(), view_with(2), "view").triangles;
  const int far = choose_for_view(square(), skin(), view_with(1), "view").triangles;
  EXPECT_NEAR(far, 2 * 100 * 100 / 16, 30);
  EXPECT_NEAR(near, 4 * far, 30);
}

TEST(ForView, LeavesOutALayerWhoseLightStaysWithinAPixel) {
  const ViewChoice c = choose_for_view(square(), skin(), view_with(1), "view");
  ASSERT_EQ(c.layers.size(), 2u);
  EXPECT_TRUE(c.layers[0].is_kept);
  EXPECT_NEAR(c.layers[0].radius_px, 2, 0.02);
  EXPECT_FALSE(c.layers[1].is_kept);
  EXPECT_NEAR(c.layers[1].radius_px, 0.6, 0.01);
  const v1::Layers kept = kept_layers(skin(), c);
  EXPECT_EQ(kept.regions(0).deep().ld_mm_size(), 3);
  EXPECT_EQ(kept.regions(0).shallow().ld_mm_size(), 0);
}

TEST(ForView, KeepsEveryLayerOfACloseUp) {
  for (const LayerChoice& c : choose_for_view(square(), skin(), view_with(5), "view").layers) {
    EXPECT_TRUE(c.is_kept) << c.layer;
  }
}

TEST(ForView, NeverTakesMoreThanAnExportForNoView) {
  ExportOptions most;
  most.triangles = 400;
  most.texture_side_px = 150;
  const ViewChoice near = choose_for_view(square(), skin(), view_with(9), "view");
  EXPECT_EQ(options_for_view(near, most).triangles, 400);
  EXPECT_EQ(options_for_view(near, most).texture_side_px, 150);
  const ViewChoice far = choose_for_view(square(), skin(), view_with(0.5), "view");
  EXPECT_EQ(options_for_view(far, most).triangles, far.triangles);
  EXPECT_LT(options_for_view(far, most).texture_side_px, 150);
}

TEST(ForView, RefusesACameraThatDoesNotSeeTheFace) {
  View away = view_with(1);
  away.camera.cam_from_rig = Mat33d::eye();
  away.camera.translation_mm = {0, 0, -1000};
  EXPECT_THROW(choose_for_view(square(), skin(), away, "view"), Error);
  View beside = view_with(1);
  beside.camera.cx = 5000;
  EXPECT_THROW(choose_for_view(square(), skin(), beside, "view"), Error);
}

}  // namespace
}  // namespace lamella::exporting
