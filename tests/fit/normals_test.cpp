#include "fit/normals.h"

#include <gtest/gtest.h>

#include "fit/smooth.h"
#include "fit/synthetic_rig.h"

namespace lamella::fit {
namespace {

using testing::Shape;

std::vector<float> errors_deg(const Burst& burst, const Image3& normals, const Shape& shape) {
  std::vector<float> errors;
  const Camera& left = burst.session->left;
  for (int y = 0; y < burst.regions.rows; ++y) {
    for (int x = 0; x < burst.regions.cols; ++x) {
      if (!burst.regions(y, x)) continue;
      const auto truth = shape(left.centre_mm(), left.ray(x, y));
      const Vec3& n = normals(y, x);
      errors.push_back(is_finite(n) ? testing::angle_deg(n, truth->normal) : 180.f);
    }
  }
  return errors;
}

TEST(Normals, OfASphereAreItsOwn) {
  const Session session = testing::make_session();
  const Shape shape = testing::sphere(60);
  const Burst burst = testing::photograph(session, shape);
  Geometry geometry = reconstruct_geometry(burst);
  const Normals n = estimate_normals(burst, &geometry);
  for (const Image3& diffuse : n.diffuse) {
    EXPECT_LT(testing::quantile(errors_deg(burst, diffuse, shape), 0.5), 0.3f);
    EXPECT_LT(testing::quantile(errors_deg(burst, diffuse, shape), 0.95), 3.f);
  }
  EXPECT_LT(testing::quantile(errors_deg(burst, n.specular, shape), 0.5), 0.5f);
}

TEST(Normals, AreRightWithNearLedsAndAGapAmongThem) {
  Session session = testing::make_session();
  std::vector<Led> leds = session.stage.leds();
  leds.erase(leds.begin() + 10, leds.begin() + 25);
  for (Led& led : leds) led.distance_mm = 800;
  session.stage = LightStage(leds);
  const Shape shape = testing::sphere(60);
  const Burst burst = testing::photograph(session, shape);
  Geometry geometry = reconstruct_geometry(burst);
  const Normals n = estimate_normals(burst, &geometry);
  EXPECT_LT(testing::quantile(errors_deg(burst, n.diffuse[1], shape), 0.5), 0.4f);
}

TEST(Normals, AreTheirNeighboursWhereAGradientIsClippedAndHardlyBelieved) {
  const Session session = testing::make_session();
  const Shape shape = testing::sphere(60);
  Burst burst = testing::photograph(session, shape);
  const cv::Rect speck(90, 100, 3, 3);
  burst.clipped_led_cross = cv::Mat3b(burst.regions.size(), cv::Vec3b(0, 0, 0));
  burst.clipped_led_cross(speck).setTo(cv::Scalar::all(255));
  burst.gradient[0].cross(speck) *= 0.6;
  Geometry geometry = reconstruct_geometry(burst);
  const Normals n = estimate_normals(burst, &geometry);
  for (int y = speck.y; y < speck.y + 3; ++y) {
    for (int x = speck.x; x < speck.x + 3; ++x) {
      const auto truth = shape(session.left.centre_mm(), session.left.ray(x, y));
      EXPECT_LT(testing::angle_deg(n.diffuse[1](y, x), truth->normal), 1.5f) << x << ", " << y;
      EXPECT_LT(n.diffuse_confidence(y, x), 0.05f);
    }
  }
}

// What the LEDs light, with noise of this share of full light; the projector's photographs stay.
Burst noisy(Burst burst, float share) {
  const NoiseModel noise{0, double(share) * double(share)};
  cv::RNG random(1);
  const auto spoil = [&](Image3* image) {
    *image = image->clone();
    for (Vec3& v : *image) {
      for (int c = 0; c < 3; ++c) {
        v[c] += float(random.gaussian(double(std::sqrt(noise.variance(v[c])))));
      }
    }
  };
  for (AnalyserPair* pair :
       {&burst.full, &burst.gradient[0], &burst.gradient[1], &burst.gradient[2]}) {
    spoil(&pair->parallel);
    spoil(&pair->cross);
  }
  burst.led_noise = burst.led_parallel_noise = noise;
  return burst;
}

TEST(Normals, OfPhotographsFullOfNoiseAreAveragedAsFarAsNoiseHidesWhatIsFiner) {
  const Session session = testing::make_session();
  const Shape shape = testing::sphere(60);
  const Burst clean = testing::photograph(session, shape);
  const auto median_deg = [&](float noise) {
    const Burst burst = noisy(clean, noise);
    Geometry geometry = reconstruct_geometry(burst);
    const Normals n = estimate_normals(burst, &geometry);
    return std::pair(testing::quantile(errors_deg(burst, n.diffuse[1], shape), 0.5),
                     testing::quantile(errors_deg(burst, n.specular, shape), 0.5));
  };
  const auto [diffuse_deg, specular_deg] = median_deg(0.02f);
  EXPECT_LT(diffuse_deg, 1.5f);
  EXPECT_LT(specular_deg, 2.2f);
  // Four times that: an average wider than the second.
  const auto [noisy_diffuse_deg, noisy_specular_deg] = median_deg(0.08f);
  EXPECT_LT(noisy_diffuse_deg, 5.1f);
  EXPECT_LT(noisy_specular_deg, 5.9f);
}

TEST(Normals, TurnWithTheRig) {
  Session session = testing::make_session(), turned_session = testing::make_session();
  const Mat33d turn(0.36, 0.48, -0.8, -0.8, 0.6, 0, 0.48, 0.64, 0.6);
  testing::rotate_rig(turn, &turned_session);
  const auto normals_of = [](const Session& s) {
    const Burst burst = testing::photograph(s, testing::sphere(60));
    Geometry geometry = reconstruct_geometry(burst);
    return estimate_normals(burst, &geometry).diffuse[1];
  };
  const Image3 straight = normals_of(session), turned = normals_of(turned_session);
  std::vector<float> apart;
  for (int y = 0; y < straight.rows; ++y) {
    for (int x = 0; x < straight.cols; ++x) {
      if (!is_finite(straight(y, x))) continue;
      apart.push_back(testing::angle_deg(cv::Matx33f(turn) * straight(y, x), turned(y, x)));
    }
  }
  ASSERT_GT(apart.size(), 3000u);
  EXPECT_LT(testing::quantile(apart, 0.99), 0.2f);
}

TEST(Normals, OfAFlatPlaneAreAllAlike) {
  const Session session = testing::make_session();
  const Shape plane = testing::stepped_plane(0, 0);
  const Burst burst = testing::photograph(session, plane);
  Geometry geometry = reconstruct_geometry(burst);
  const Normals n = estimate_normals(burst, &geometry);
  EXPECT_LT(testing::quantile(errors_deg(burst, n.diffuse[0], plane), 0.99), 0.5f);
}

TEST(Normals, SeeLessOfTheLedsAtTheFootOfAStep) {
  const Session session = testing::make_session();
  const Burst burst = testing::photograph(session, testing::stepped_plane(60, 0));
  Geometry geometry = reconstruct_geometry(burst);
  const Normals n = estimate_normals(burst, &geometry);
  const cv::Vec2d foot = session.left.project(Vec3d(0, 36, 0));
  const cv::Vec2d top = session.left.project(Vec3d(0, 0, 60));
  EXPECT_LT(n.ambient_visibility(int(foot[1]), int(foot[0])), 0.8f);
  EXPECT_GT(n.ambient_visibility(int(top[1]), int(top[0])), 0.97f);
  EXPECT_LT(n.diffuse_confidence(int(foot[1]), int(foot[0])),
            n.diffuse_confidence(int(top[1]), int(top[0])));
}

TEST(Smoothing, KeepsASlopeUpToItsEdgeAndDoesNotCrossASilhouette) {
  Image1 distance(40, 40), value(40, 40);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      distance(y, x) = x < 20 ? 1000.f : 1050.f;
      value(y, x) = x < 20 ? 3.f * x + y : 500.f - 2.f * x;
    }
  }
  const Image1 smooth = smooth_along_surface(value, span_for(distance, 0.25f, 2), 2.f);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) ASSERT_NEAR(smooth(y, x), value(y, x), 1e-3f);
  }
}

// A bar 6 mm high that stands 20 mm before a plane.
std::optional<testing::SurfacePoint> bar_before_a_plane(const Vec3d& o, const Vec3d& d) {
  const Vec3d front = o + d * ((20 - o[2]) / d[2]);
  if (std::abs(front[1]) < 3 && std::abs(front[0]) < 50) return {{front, {0, 0, 1}}};
  const Vec3d back = o + d * (-o[2] / d[2]);
  if (std::abs(back[0]) < 60) return {{back, {0, 0, 1}}};
  return std::nullopt;
}

TEST(Merge, KeepsWhatWasMeasuredBeforeASilhouetteThoughItIsNotSure) {
  const Session session = testing::make_session();
  const Burst burst = testing::photograph(session, bar_before_a_plane);
  Geometry geometry = reconstruct_geometry(burst);
  for (int i = 0; i < int(geometry.sigma_mm.total()); ++i) {
    const cv::Point p(i % geometry.sigma_mm.cols, i / geometry.sigma_mm.cols);
    if (geometry.position_mm(p)[2] > 15) geometry.sigma_mm(p) = 0.5f;
  }
  Normals normals;
  normals.diffuse[1] = Image3(burst.regions.size(), Vec3(0, 0, 1));
  normals.diffuse_confidence = Image1(burst.regions.size(), 1.f);
  merge_with_normals(burst, normals, &geometry);
  EXPECT_NEAR(geometry.position_mm(100, 80)[2], 20, 0.3f);
  EXPECT_NEAR(geometry.position_mm(60, 80)[2], 0, 0.1f);
}

}  // namespace
}  // namespace lamella::fit
