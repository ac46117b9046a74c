#include "fit/binned.h"

#include <gtest/gtest.h>

#include "calib/pattern_scale.h"
#include "fit/synthetic_rig.h"

namespace lamella::fit {
namespace {

Session small_session() {
  Session session = testing::make_session();
  session.left.width = 11;  // the last block has one column
  session.left.height = 8;
  return session;
}

Burst burst_of(const Session& session) {
  const cv::Size size(session.left.width, session.left.height);
  Burst burst;
  burst.session = &session;
  burst.regions = Labels(size, 1);
  burst.clipped_led = Mask(size, 0);
  burst.clipped_projector = Mask(size, 0);
  burst.black = Image3(size, Vec3(1, 2, 3));
  burst.led_noise = burst.led_parallel_noise = {4, 8};
  return burst;
}

TEST(Binned, ABlocksRayIsThatOfItsCentre) {
  const Session session = small_session();
  for (const int bin_px : {2, 3}) {
    const Session binned = binned_session(session, bin_px);
    const double centre = (bin_px - 1) / 2.0;
    EXPECT_LT(cv::norm(binned.left.ray(0, 0) - session.left.ray(centre, centre)), 1e-12);
    EXPECT_LT(
        cv::norm(binned.left.ray(2, 1) - session.left.ray(2 * bin_px + centre, bin_px + centre)),
        1e-12);
  }
}

TEST(Binned, ABlockIsTheMeanOfItsPixelsHoweverFewItHas) {
  const Session session = small_session(), binned = binned_session(session, 2);
  Burst burst = burst_of(session);
  burst.black(2, 4) = Vec3(5, 2, 3);
  burst.black(7, 10) = Vec3(3, 2, 3);
  const Image3 black = binned_burst(burst, binned, 2).black;
  ASSERT_EQ(black.size(), cv::Size(6, 4));
  EXPECT_EQ(black(1, 2), Vec3(2, 2, 3));
  EXPECT_EQ(black(3, 5), Vec3(2, 2, 3));  // two pixels
  EXPECT_EQ(black(0, 0), Vec3(1, 2, 3));
}

TEST(Binned, ABlockHasTheLabelOfMostOfItsPixelsAndIsClippedWhereOneIs) {
  const Session session = small_session(), binned = binned_session(session, 2);
  Burst burst = burst_of(session);
  burst.regions(cv::Rect(0, 0, 2, 2)).setTo(2);
  burst.regions(0, 0) = 0;
  burst.clipped_led(5, 3) = 255;
  const Burst small = binned_burst(burst, binned, 2);
  EXPECT_EQ(small.regions(0, 0), 2);
  EXPECT_EQ(small.regions(0, 1), 1);
  EXPECT_EQ(small.clipped_led(2, 1), 255);
  EXPECT_EQ(cv::countNonZero(small.clipped_led), 1);
}

TEST(Binned, BlocksAreTheLargestThatResolveThePatterns) {
  Session session = testing::make_session();
  const double mm = session.left.pixel_mm(), projector_mm = session.projector.pixel_mm();
  session.patterns.stripe_period_px = 3.1 * kLeastBlockScale.stripe_px * mm / projector_mm;
  session.patterns.dot_diameter_px = 9 * kLeastBlockScale.dot_px * mm / projector_mm;
  EXPECT_EQ(resolving_bin_px(session, 2), 2);
  EXPECT_EQ(resolving_bin_px(session, 16), 3);
  session.patterns.dot_diameter_px = 2.1 * kLeastBlockScale.dot_px * mm / projector_mm;
  EXPECT_EQ(resolving_bin_px(session, 16), 2);
  session.patterns.dot_diameter_px = 0.1 * kLeastBlockScale.dot_px * mm / projector_mm;
  EXPECT_EQ(resolving_bin_px(session, 16), 1);
}

TEST(Binned, TheNoiseOfFourPixelsMeanIsAQuarter) {
  const Session session = small_session(), binned = binned_session(session, 2);
  const Burst small = binned_burst(burst_of(session), binned, 2);
  EXPECT_FLOAT_EQ(small.led_noise.variance(1), 3);
  EXPECT_FLOAT_EQ(small.led_parallel_noise.variance(1), 3);
}

// Blocks whose pixels see a plane that faces the camera, `step_mm` further on the right half.
class Unbin : public ::testing::Test {
 protected:
  LayerMaps maps_with_a_step(double step_mm) const {
    const cv::Size blocks(binned_.left.width, binned_.left.height);
    LayerMaps maps;
    maps.position_mm = Image3(blocks);
    maps.specular_intensity = Image1(blocks);
    for (int y = 0; y < blocks.height; ++y) {
      for (int x = 0; x < blocks.width; ++x) {
        const double away_mm = depth_mm_ + (x < 3 ? 0 : step_mm);
        maps.position_mm(y, x) = at_depth(binned_.left, x, y, away_mm);
        maps.specular_intensity(y, x) = float(x);
      }
    }
    return maps;
  }

  static Vec3 at_depth(const Camera& camera, double u, double v, double depth_mm) {
    const Vec3d ray = camera.ray(u, v), centre = camera.centre_mm();
    return Vec3(centre + ray * (depth_mm / camera.depth_mm(centre + ray)));
  }

  const Session session_ = small_session(), binned_ = binned_session(session_, 2);
  const double depth_mm_ = session_.left.depth_mm({0, 0, 0});
  Labels regions_ = Labels(session_.left.height, session_.left.width, uchar(1));
};

TEST_F(Unbin, GivesAPlaneBackWhereItWas) {
  LayerMaps maps = maps_with_a_step(0);
  unbin_maps(regions_, session_.left, 2, &maps);
  ASSERT_EQ(maps.position_mm.size(), regions_.size());
  for (int x = 1; x < 10; ++x) {
    const Vec3 expected = at_depth(session_.left, x, 3, depth_mm_);
    EXPECT_LT(length(maps.position_mm(3, x) - expected), 1e-2f) << x;
    EXPECT_NEAR(maps.specular_intensity(3, x), (x + 0.5) / 2 - 0.5, 1e-5) << x;
  }
}

TEST_F(Unbin, TakesNothingFromBeyondASilhouette) {
  LayerMaps maps = maps_with_a_step(200);
  unbin_maps(regions_, session_.left, 2, &maps);
  EXPECT_FLOAT_EQ(maps.specular_intensity(3, 5), 2);
  EXPECT_FLOAT_EQ(maps.specular_intensity(3, 6), 3);
}

TEST_F(Unbin, KnowsNothingOutsideTheRegionsAndWhereNoBlockDoes) {
  LayerMaps maps = maps_with_a_step(0);
  regions_(0, 0) = 0;
  maps.position_mm(3, 5) = maps.position_mm(2, 5) = Vec3::all(kNaN);
  maps.position_mm(3, 4) = maps.position_mm(2, 4) = Vec3::all(kNaN);
  unbin_maps(regions_, session_.left, 2, &maps);
  EXPECT_TRUE(std::isnan(maps.specular_intensity(0, 0)));
  EXPECT_TRUE(std::isnan(maps.specular_intensity(7, 10)));
  EXPECT_TRUE(is_finite(maps.specular_intensity(7, 7)));  // beside one that knows
}

TEST(Quality, NamesWhatThereIsWhereANameIsNone) {
  EXPECT_EQ(quality_from_name("draft").bin_px, 2);
  EXPECT_EQ(quality_from_name("standard").lobe_samples, Quality().lobe_samples);
  try {
    quality_from_name("best");
    FAIL();
  } catch (const std::exception& why) {
    EXPECT_NE(std::string(why.what()).find("draft, standard, reference"), std::string::npos);
  }
}

}  // namespace
}  // namespace lamella::fit
