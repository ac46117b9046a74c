#include "render/rim.h"

#include <gtest/gtest.h>

#include "render/completion.h"
#include "render/scene.h"

namespace lamella::render {
namespace {

// A staircase: a circle of large pixels, with a notch.
Mask notched_circle() {
  Mask known(240, 240, uchar(0));
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 240; ++x) {
      known(y, x) = std::hypot(x / 4 * 4 + 1.5 - 120, y / 4 * 4 + 1.5 - 120) < 90 ? 255 : 0;
    }
  }
  known(cv::Rect(20, 117, 30, 5)).setTo(0);
  return known;
}

TEST(Rim, RunsSmoothlyAroundWhatIsKnown) {
  const Mask known = notched_circle();
  const Image1 inside_px = rim_around(known);
  EXPECT_EQ(cv::countNonZero(known & (inside_px <= 0.f)), 0);
  EXPECT_GT(inside_px(119, 45), 0);                     // the notch
  for (int degrees = -150; degrees < 150; ++degrees) {  // away from the notch
    const double angle = degrees * M_PI / 180;
    double r = 60;
    while (inside_px(int(120 + r * std::sin(angle) + .5), int(120 + r * std::cos(angle) + .5)) >
           0) {
      r += .25;
    }
    EXPECT_NEAR(r, 93, 2.5) << degrees;  // the staircase departs by 4
  }
}

TEST(Rim, HasASurfaceAllAlongAlsoWithACoarseMesh) {
  Skin skin;
  skin.deep = skin.shallow = Vec3::all(0.3f);
  const CompleteMaps whole = complete_maps(sphere(front_camera(120, 1), 40, skin).maps);
  for (int y = 2; y < 118; ++y) {
    for (int x = 2; x < 118; ++x) {
      if (whole.inside_px(y, x) > -3) {
        EXPECT_TRUE(is_finite(whole.maps.position_mm(y, x)));
      }
    }
  }
}

}  // namespace
}  // namespace lamella::render
