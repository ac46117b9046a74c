#include "fit/fringe_phase.h"

#include <gtest/gtest.h>

#include "fit/synthetic_rig.h"

namespace lamella::fit {
namespace {

struct Ramp {
  Session session = testing::make_session();
  std::vector<Image3> fringe;
  Image3 white = Image3(128, 256, Vec3(.4f, .3f, .2f));
  Mask wanted = Mask(128, 256, uchar(255));

  static double column(int y, int x) { return 8.5 + 4.7 * x + 0.3 * y; }

  Ramp() {
    for (size_t k = 0; k < 4; ++k) {
      fringe.emplace_back(white.size());
      for (int y = 0; y < white.rows; ++y) {
        for (int x = 0; x < white.cols; ++x) {
          fringe[k](y, x) = white(y, x).mul(testing::fringe_value(session, k, column(y, x)));
        }
      }
    }
  }

  ProjectorColumns decode() const {
    return decode_columns(fringe, white, wanted,
                          {session.patterns.fringe_periods, 1280, {1e-8, 1e-6}});
  }
};

TEST(Fringes, GiveTheColumnThoughRedIsBlurredMoreThanBlue) {
  const Ramp ramp;
  const ProjectorColumns columns = ramp.decode();
  for (int y = 0; y < ramp.white.rows; ++y) {
    for (int x = 0; x < ramp.white.cols; ++x) {
      ASSERT_NEAR(columns.u_px(y, x), Ramp::column(y, x), 0.03) << "at " << x << ", " << y;
    }
  }
}

TEST(Fringes, DoNotMindTheColourOfTheSkin) {
  Ramp ramp;
  for (Image3* image :
       {&ramp.white, &ramp.fringe[0], &ramp.fringe[1], &ramp.fringe[2], &ramp.fringe[3]}) {
    for (int x = 100; x < 150; ++x) {
      for (int y = 0; y < image->rows; ++y) (*image)(y, x) = (*image)(y, x).mul({1, .3f, .1f});
    }
  }
  const ProjectorColumns columns = ramp.decode();
  for (int x = 90; x < 160; ++x) EXPECT_NEAR(columns.u_px(64, x), Ramp::column(64, x), 0.03);
}

TEST(Fringes, HaveNoAnswerWithoutLightNorOutsideWhatIsWanted) {
  Ramp ramp;
  ramp.white(20, 30) = Vec3(0, 0, 0);
  ramp.wanted(40, 50) = 0;
  const ProjectorColumns columns = ramp.decode();
  EXPECT_TRUE(std::isnan(columns.u_px(20, 30)));
  EXPECT_TRUE(std::isnan(columns.u_px(40, 50)));
  EXPECT_FALSE(std::isnan(columns.u_px(40, 51)));
}

TEST(Fringes, TheirSigmaIsTheScatterOfTheColumn) {
  Ramp ramp;
  cv::RNG random(7);
  const NoiseModel noise{4e-6, 1e-4};
  for (Image3& image : ramp.fringe) {
    for (Vec3& v : image) {
      for (int c = 0; c < 3; ++c) v[c] += float(random.gaussian(std::sqrt(noise.variance(v[c]))));
    }
  }
  const ProjectorColumns columns = decode_columns(
      ramp.fringe, ramp.white, ramp.wanted, {ramp.session.patterns.fringe_periods, 1280, noise});
  double squares = 0;
  for (int y = 0; y < ramp.white.rows; ++y) {
    for (int x = 0; x < ramp.white.cols; ++x) {
      squares += std::pow((columns.u_px(y, x) - Ramp::column(y, x)) / columns.sigma_px(y, x), 2);
    }
  }
  // The white is noise-free here, and is not taken to be: a little less than one.
  const double ratio = std::sqrt(squares / double(ramp.white.total()));
  EXPECT_GT(ratio, 0.6);
  EXPECT_LT(ratio, 1.1);
}

}  // namespace
}  // namespace lamella::fit
