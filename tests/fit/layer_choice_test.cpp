// One diffuse layer or two.
#include "fit/layer_choice.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "fit/scattering.h"
#include "lit_plane.h"
#include "model/multipole.h"

namespace lamella::fit {
namespace {

using testing::LitPlane;
using testing::RadialKernel;

constexpr std::array<double, 3> kLd_mm{1.9, 0.95, 0.7};
constexpr double kShare = 0.5, kThickness_mm = 0.5;

RadialKernel dipole(double ld_mm) {
  const model::Dipole<double> skin{model::alpha_from_s(0.38 / ld_mm), ld_mm};
  return [=](double r) { return model::dipole_reflectance(skin, r); };
}

// Half of the light comes from a slab over the dipole.
RadialKernel under_a_slab(double ld_mm) {
  const model::Dipole<double> skin{model::alpha_from_s(0.38 / ld_mm), ld_mm};
  const model::Multipole<double> slab{0.93, 0.54, kThickness_mm};
  const double deep = (1 - kShare) / model::diffuse_reflectance_at_s(0.38 / ld_mm);
  const double shallow = kShare / model::multipole_total(slab);
  return [=](double r) {
    return deep * model::dipole_reflectance(skin, r) +
           shallow * model::multipole_reflectance(slab, r);
  };
}

// What camera and projector leave of a kernel: its convolution with a Gaussian, by rings.
RadialKernel through_lenses(const RadialKernel& kernel, double sigma_mm) {
  const double s2 = sigma_mm * sigma_mm;
  return [=](double r) {
    double sum = 0;
    for (double s = 0.002; s < 20; s *= 1.01) {
      const double x = r * s / s2;
      const double ring = x < 50
                              ? std::exp(-(r * r + s * s) / (2 * s2)) * std::cyl_bessel_i(0.0, x)
                              : std::exp(-(r - s) * (r - s) / (2 * s2)) / std::sqrt(2 * M_PI * x);
      sum += kernel(s) * ring * s * s * 0.01 / s2;
    }
    return sum;
  };
}

LitPlane noisy_plane(RadialKernel (*kernel)(double)) {
  LitPlane plane = testing::make_plane(Vec3(.3f, .2f, .15f));
  const double blur_mm = footprint_mm(plane.session->left, plane.session->projector);
  const auto seen = [&](int c) { return through_lenses(kernel(kLd_mm[size_t(c)]), blur_mm); };
  testing::photograph_dots({seen(0), seen(1), seen(2)}, &plane);
  testing::add_noise(0.002, &plane.burst.dots);
  return plane;
}

const LitPlane& plane_of_one_layer() {
  static const LitPlane plane = noisy_plane(dipole);
  return plane;
}

const LitPlane& plane_of_two_layers() {
  static const LitPlane plane = noisy_plane(under_a_slab);
  return plane;
}

struct Fitted {
  Separation separation;
  Scattering scattering;
};

Fitted fit(const LitPlane& plane, LayerUse use) {
  const cv::Size size(testing::kWidth, testing::kHeight);
  Fitted fitted;
  fitted.separation.shallow_albedo = Image3(size, Vec3(.2f, .2f, .2f));
  fitted.separation.deep_albedo = Image3(size, Vec3(.2f, .2f, .2f));
  fitted.separation.confidence = Image1(size, 0.75f);
  fitted.separation.deep_confidence = Image1(size, 0.5f);
  fitted.scattering =
      fit_scattering(plane.burst, plane.geometry, plane.normals, use, &fitted.separation);
  return fitted;
}

TEST(LayerChoice, SingleIsOneDipoleForAllTheLight) {
  const Fitted fitted = fit(plane_of_one_layer(), LayerUse::kSingle);
  const RegionScattering& skin = fitted.scattering.regions[0];
  EXPECT_TRUE(skin.deep_fitted);
  EXPECT_FALSE(skin.shallow_fitted);
  EXPECT_EQ(skin.shallow_why, "one layer was asked for (--layers single)");
  EXPECT_EQ(skin.shallow_ld_mm[0], 0);
  EXPECT_EQ(fitted.separation.shallow_albedo(50, 50), Vec3(0, 0, 0));
  EXPECT_NEAR(fitted.separation.deep_albedo(50, 50)[1], 0.4, 1e-6) << "the same total";
  EXPECT_EQ(fitted.separation.deep_confidence(50, 50), 0.75f) << "nothing is left by a share";
  EXPECT_NEAR(fitted.scattering.deep_alpha(50, 50)[1], *model::alpha_from_reflectance(0.4), 1e-4);
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(skin.ld_mm[c] / kLd_mm[c], 1, 0.1) << "channel " << c;
    EXPECT_GT(skin.ld_mm_stddev[c], 0);
  }
}

TEST(LayerChoice, WhatOneDipoleWouldBeIsToldBesideTwoLayersThatAreKept) {
  const Fitted both = fit(plane_of_two_layers(), LayerUse::kAuto);
  const Fitted single = fit(plane_of_two_layers(), LayerUse::kSingle);
  const RegionScattering& skin = both.scattering.regions[0];
  EXPECT_TRUE(skin.shallow_fitted) << skin.shallow_why;
  EXPECT_EQ(both.separation.shallow_albedo(50, 50), Vec3(.2f, .2f, .2f));
  for (size_t c = 0; c < 3; ++c) {
    const SingleLayer& one = skin.single_layer[c];
    EXPECT_EQ(one.ld_mm, single.scattering.regions[0].ld_mm[c]);
    EXPECT_NE(one.ld_mm, skin.ld_mm[c]);
    EXPECT_GT(one.rms, 0.03) << "one dipole is not both layers";
  }
}

// Of dots that were left out, in percent of squared error, after "left out with".
double gain_told(const std::string& why) {
  const std::string mark = "left out with ";
  const size_t at = why.find(mark);
  EXPECT_NE(at, std::string::npos) << why;
  const double percent = std::stod(why.substr(at + mark.size()));
  return why.find("more error") == std::string::npos ? percent : -percent;
}

TEST(LayerChoice, DotsLeftOutTellWhatTheSecondLayerIsWorth) {
  const auto why = [](const LitPlane& plane) {
    return fit(plane, LayerUse::kAuto).scattering.regions[0].shallow_why;
  };
  EXPECT_GT(gain_told(why(plane_of_two_layers())), 30);
  EXPECT_EQ(why(plane_of_two_layers()).rfind("kept: ", 0), 0u);
}

TEST(LayerChoice, OneDotIsTooFewToCompareByAndSaysSo) {
  EXPECT_NE(describe_contest({}).find("too few"), std::string::npos);
  LayerContest contest;
  contest.gain = {-0.1, -0.2, -0.1};
  EXPECT_NE(describe_contest({contest, contest, contest}).find("13 +- 2 % more"), std::string::npos)
      << describe_contest({contest, contest, contest});
}

TEST(LayerChoice, ALayerIsKeptForItsLightWhereTheDotsDoNotSpeakForIt) {
  LayerContest contest;
  contest.gain = {0.4, 0.5, 0.6};
  EXPECT_EQ(reason_to_keep({contest, contest, contest}, 0.35),
            "kept: the stripes show 35 % of its diffuse light as shallow, and both layers foresee "
            "dots that were left out with 50 +- 3 % less error (squared) than one dipole");
  contest.gain = {-0.1, -0.2, -0.1};
  EXPECT_EQ(reason_to_keep({contest, contest, contest}, 0.35),
            "kept: the stripes show 35 % of its diffuse light as shallow, and the dots do not "
            "decide: both layers foresee dots that were left out with 13 +- 2 % more error "
            "(squared) than one dipole");
}

TEST(LayerChoice, NamesOfChoicesAreListedWhereOneIsNotKnown) {
  EXPECT_EQ(layer_use_from_name("single"), LayerUse::kSingle);
  try {
    layer_use_from_name("two");
    FAIL() << "no such choice";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("auto, single"), std::string::npos);
  }
}

}  // namespace
}  // namespace lamella::fit
