#include "render/completion.h"

#include <gtest/gtest.h>

#include "render/scene.h"

namespace lamella::render {
namespace {

TEST(FillSmoothly, GoesOnWithAPlaneWhereTheBorderIsOne) {
  Image1 map(40, 40);
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 40; ++j) map(i, j) = 2.f * float(i) - 3.f * float(j) + 1;
  }
  const Image1 whole = map.clone();
  map(cv::Rect(12, 15, 14, 9)).setTo(kNaN);
  fill_smoothly(Mask(40, 40, 255), &map);
  EXPECT_LT(cv::norm(map, whole, cv::NORM_INF), 0.01);
}

TEST(FillSmoothly, LeavesAloneWhatIsNotWanted) {
  Image1 map(10, 10, 1.f);
  map(5, 5) = kNaN;
  fill_smoothly(Mask(10, 10, uchar(0)), &map);
  EXPECT_TRUE(std::isnan(map(5, 5)));
}

TEST(Holes, AreBetweenKnownPixelsAndNotAcrossAWideGap) {
  Mask known(1, 100, uchar(0));
  for (int j : {10, 15, 80}) known(0, j) = 255;
  const Mask holes = holes_of(known, 20);
  EXPECT_EQ(cv::countNonZero(holes), 4);
  EXPECT_EQ(holes(0, 12), 255);
  EXPECT_EQ(holes(0, 40), 0);
}

TEST(CompleteMaps, GivesEveryPositionANormalAlbedosAndALabel) {
  Skin skin;
  skin.deep = skin.shallow = Vec3::all(0.3f);
  Subject s = sphere(front_camera(90, 1), 30, skin);
  s.maps.position_mm(cv::Rect(40, 40, 6, 6)).setTo(Vec3::all(kNaN));
  s.maps.regions(cv::Rect(40, 40, 6, 6)).setTo(0);
  s.maps.deep_albedo(50, 50) = Vec3::all(kNaN);
  const LayerMaps whole = complete_maps(s.maps).maps;
  EXPECT_NEAR(length(whole.position_mm(43, 43)), 30, 0.3);
  int more = 0;
  for (int i = 0; i < 90; ++i) {
    for (int j = 0; j < 90; ++j) {
      if (!is_finite(whole.position_mm(i, j))) continue;
      more += !is_finite(s.maps.position_mm(i, j));
      EXPECT_NEAR(length(whole.normal_specular(i, j)), 1, 1e-4);
      EXPECT_NEAR(whole.deep_albedo(i, j)[0], 0.3, 1e-4);
      EXPECT_EQ(whole.regions(i, j), 1);
    }
  }
  EXPECT_GT(more, 36 + 200);  // the hole and a rim
}

}  // namespace
}  // namespace lamella::render
