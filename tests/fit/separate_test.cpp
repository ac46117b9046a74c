#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "fit/binned.h"
#include "fit/scattering.h"
#include "lit_plane.h"

namespace lamella::fit {
namespace {

using testing::LitPlane;

constexpr double kLength_mm = 0.6;

// Fourier transform of exp(-r/l)/(2 pi l r).
double transfer(double cycles_per_mm) {
  const double x = 2 * M_PI * kLength_mm * cycles_per_mm;
  return 1 / std::sqrt(1 + x * x);
}

// Of a continuous shift: twice the brightness in a white stripe's middle, above the mean.
double true_swing(const Session& session) {
  const double f = session.projector.fx / 1000 / session.patterns.stripe_period_px;
  double swing = 0;
  for (int h = 1; h < 4000; h += 2) {
    swing += 4 / (M_PI * h) * (h % 4 == 1 ? 1 : -1) * transfer(h * f);
  }
  return swing;
}

LitPlane striped_plane(const Vec3& white) {
  LitPlane plane = testing::make_plane(white, 2100);
  testing::photograph_stripes(transfer, &plane);
  return plane;
}

double mean_share(const LitPlane& plane, const Separation& s, int quarter) {
  double sum = 0, count = 0;
  for (int y = 4; y < testing::kHeight - 4; ++y) {
    for (int x = 4; x < testing::kWidth - 4; ++x) {
      const float u = plane.geometry.projector_px(y, x)[0];
      if (quarter >= 0 && int(2 * (u - 2 * std::floor(u / 2))) != quarter) continue;
      sum +=
          double(s.shallow_albedo(y, x)[1] / (s.shallow_albedo(y, x)[1] + s.deep_albedo(y, x)[1]));
      count += 1;
    }
  }
  return sum / count;
}

TEST(Separation, FindsTheSwingOfAContinuousShift) {
  const LitPlane plane = striped_plane(Vec3(.3f, .2f, .15f));
  const Separation s = separate_layers(plane.burst, plane.geometry, plane.normals);
  EXPECT_NEAR(mean_share(plane, s, -1) / true_swing(*plane.session), 1, 0.03);
  EXPECT_LT(s.closure_rms, 1e-3);
}

// The same plane in blocks, each of which sees its pixels' mean.
LitPlane in_blocks(const LitPlane& fine, int bin_px) {
  LitPlane plane;
  plane.session = std::make_unique<Session>(binned_session(*fine.session, bin_px));
  plane.burst = binned_burst(fine.burst, *plane.session, bin_px);
  plane.burst.quality.bin_px = bin_px;
  const auto shrink = [&](const auto& map) {
    std::decay_t<decltype(map)> small;
    cv::resize(map, small, plane.burst.regions.size(), 0, 0, cv::INTER_AREA);
    return small;
  };
  const Geometry& g = fine.geometry;
  plane.geometry.position_mm = shrink(g.position_mm);
  plane.geometry.to_projector = plane.geometry.to_camera = shrink(g.to_camera);
  plane.geometry.projector_px = shrink(g.projector_px);
  plane.geometry.projector_irradiance = shrink(g.projector_irradiance);
  plane.normals.specular = shrink(fine.normals.specular);
  for (Image3& n : plane.normals.diffuse) n = plane.normals.specular;
  plane.normals.ambient_visibility = shrink(fine.normals.ambient_visibility);
  return plane;
}

// Blocks of 0.95 mm see 2.5 of themselves in a period.
TEST(Separation, FindsTheSwingOfAPixelThroughBlocksOfThem) {
  LitPlane plane = striped_plane(Vec3(.3f, .2f, .15f));
  const LitPlane blocks = in_blocks(plane, 2);
  const Separation s = separate_layers(blocks.burst, blocks.geometry, blocks.normals);
  const Image3 share = s.shallow_albedo / (s.shallow_albedo + s.deep_albedo);
  const cv::Rect inside(4, 4, testing::kWidth / 2 - 8, testing::kHeight / 2 - 8);
  EXPECT_NEAR(cv::mean(share(inside))[1] / true_swing(*plane.session), 1, 0.07);
}

TEST(Separation, HasNoMoireAgainstTheProjectorsColumns) {
  const LitPlane plane = striped_plane(Vec3(.3f, .2f, .15f));
  const Separation s = separate_layers(plane.burst, plane.geometry, plane.normals);
  const double whole = mean_share(plane, s, -1);
  for (int quarter = 0; quarter < 4; ++quarter) {
    EXPECT_NEAR(mean_share(plane, s, quarter) / whole, 1, 0.02) << "quarter " << quarter;
  }
}

TEST(Separation, NoiseDoesNotMakeAShallowLayer) {
  LitPlane plane = striped_plane(Vec3(.02f, .02f, .02f));
  const Separation clean = separate_layers(plane.burst, plane.geometry, plane.normals);
  plane.burst.projector_noise = {1e-6, 0};
  for (Image3& image : plane.burst.stripes) testing::add_noise(0.001, &image);
  const Separation noisy = separate_layers(plane.burst, plane.geometry, plane.normals);
  EXPECT_NEAR(mean_share(plane, noisy, -1), mean_share(plane, clean, -1), 0.015);
}

TEST(Separation, ShallowAndDeepSumToTwiceTheLitPhotograph) {
  const LitPlane plane = striped_plane(Vec3(.3f, .2f, .15f));
  const Separation s = separate_layers(plane.burst, plane.geometry, plane.normals);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(s.shallow_albedo(99, 80)[c] + s.deep_albedo(99, 80)[c],
                2 * plane.burst.front_lit(99, 80)[c], 0.03f);
  }
}

double mean_over_skin(const Image1& map) {
  const cv::Rect inside(4, 4, testing::kWidth - 8, testing::kHeight - 8);
  return cv::mean(map(inside))[0];
}

// An error of the share is a greater part of what it leaves, the less that is.
TEST(Separation, IsLessSureOfTheDeepAlbedoWhereMostLightIsShallow) {
  const auto nearly_all = [](double) { return 0.75; };
  const auto hardly_any = [](double) { return 0.15; };
  const auto separated = [](const std::function<double(double)>& transfer) {
    LitPlane plane = testing::make_plane(Vec3(.3f, .2f, .15f), 2100);
    testing::photograph_stripes(transfer, &plane);
    return separate_layers(plane.burst, plane.geometry, plane.normals);
  };
  const Separation most = separated(nearly_all), least = separated(hardly_any);
  ASSERT_LT(cv::mean(least.shallow_albedo)[1], 0.5 * cv::mean(most.shallow_albedo)[1]);
  EXPECT_LT(mean_over_skin(most.deep_confidence), 0.9 * mean_over_skin(least.deep_confidence));
  EXPECT_GT(mean_over_skin(most.confidence), 0.95 * mean_over_skin(least.confidence));
}

TEST(Separation, TakesNothingFromAStripeThatIsClipped) {
  const LitPlane plane = striped_plane(Vec3(.3f, .2f, .15f));
  LitPlane dazzled = striped_plane(Vec3(.3f, .2f, .15f));
  const cv::Rect patch(60, 60, 30, 30);
  dazzled.burst.clipped_stripes = Mask(testing::kHeight, testing::kWidth, uchar(0));
  dazzled.burst.clipped_stripes(patch).setTo(255);
  // As far as the sensor goes: what is brightest is cut.
  for (Image3& image : dazzled.burst.stripes) {
    cv::Mat cut = image(patch);
    cv::min(cut, cv::Scalar(.16, .107, .08), cut);
  }
  const Separation sees = separate_layers(plane.burst, plane.geometry, plane.normals);
  const Separation lacks = separate_layers(dazzled.burst, dazzled.geometry, dazzled.normals);
  const double truth = cv::mean(sees.shallow_albedo(patch))[1];
  EXPECT_NEAR(cv::mean(lacks.shallow_albedo(patch))[1] / truth, 1, 0.03);
  EXPECT_LT(cv::mean(lacks.confidence(patch))[0], 0.7 * cv::mean(sees.confidence(patch))[0]);
  EXPECT_LT(lacks.closure_rms, 1e-3);
}

TEST(Separation, BackgroundIsLeftUnknown) {
  LitPlane plane = striped_plane(Vec3(.3f, .2f, .15f));
  plane.burst.regions(10, 10) = 0;
  const Separation s = separate_layers(plane.burst, plane.geometry, plane.normals);
  EXPECT_TRUE(std::isnan(s.deep_albedo(10, 10)[0]));
}

}  // namespace
}  // namespace lamella::fit
