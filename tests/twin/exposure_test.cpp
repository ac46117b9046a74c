#include "twin/exposure.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "twin/sensor.h"

namespace lamella::twin {
namespace {

constexpr int kLeds = 150, kFringes = 4;

v1::ExposureReport one_second(double from_rad, double to_rad) {
  v1::ExposureReport r;
  r.set_open_us(0);
  r.set_close_us(1e6);
  r.set_led_reference_us(5e5);
  r.set_projector_reference_us(5e5);
  v1::AnalyserSpan* a = r.add_analyser();
  a->set_from_us(0);
  a->set_to_us(1e6);
  a->set_from_rad(from_rad);
  a->set_to_rad(to_rad);
  return r;
}

v1::LedSpan* add_leds(v1::ExposureReport* r, double on_us, double off_us, int code) {
  v1::LedSpan* span = r->add_leds();
  span->set_on_us(on_us);
  span->set_off_us(off_us);
  std::string codes;
  for (int i = 0; i < kLeds; ++i) codes += {char(code & 0xff), char(code >> 8)};
  span->set_codes(codes);
  return span;
}

Exposure read(const v1::ExposureReport& r) { return read_exposure(r, kLeds, kFringes); }

TEST(Malus, IntegratesALinearMoveExactly) {
  EXPECT_DOUBLE_EQ(malus_integral(0, 3, 0, 0), 3);
  EXPECT_NEAR(malus_integral(0, 3, M_PI / 2, M_PI / 2), 0, 1e-15);
  EXPECT_NEAR(malus_integral(0, 2, 0, M_PI / 2), 1, 1e-15);
  double sum = 0;
  const double from = 0.2, to = 1.1;
  for (int i = 0; i < 100000; ++i) {
    sum += 2e-5 * std::pow(std::cos(from + (to - from) * (i + 0.5) / 100000), 2);
  }
  EXPECT_NEAR(malus_integral(1, 3, from, to), sum, 1e-9);
}

TEST(Malus, HasNoJumpWhereTheMoveBecomesSmall) {
  EXPECT_NEAR(malus_integral(0, 1, 0.7, 0.7 + 1.01e-6), malus_integral(0, 1, 0.7, 0.7 + 0.99e-6),
              1e-7);
}

TEST(ReadExposure, WeighsLightByTheTimeItWasOn) {
  v1::ExposureReport r = one_second(0, 0);
  add_leds(&r, 1e5, 6e5, 4095);
  const Exposure e = read(r);
  ASSERT_EQ(e.contributions.size(), 1u);
  EXPECT_DOUBLE_EQ(e.contributions[0].polarized, 1);
  EXPECT_DOUBLE_EQ(e.contributions[0].depolarized, 0.5);
}

TEST(ReadExposure, LosesLightToALateBlank) {
  v1::ExposureReport r = one_second(0, 0);
  add_leds(&r, 2e5, 6e5, 4095);
  EXPECT_DOUBLE_EQ(read(r).contributions[0].depolarized, 0.4);
}

TEST(ReadExposure, SeesAnAnalyserThatStillMoves) {
  v1::ExposureReport r = one_second(0, M_PI / 2);
  add_leds(&r, 0, 5e5, 4095);  // the first half of the move
  EXPECT_NEAR(read(r).contributions[0].polarized, 0.5 + 1 / M_PI, 1e-12);
}

TEST(ReadExposure, TakesNoAnalyserForACrossedOne) {
  v1::ExposureReport r = one_second(0, 0);
  r.clear_analyser();
  add_leds(&r, 0, 5e5, 100);
  EXPECT_EQ(read(r).contributions[0].polarized, 0);
}

TEST(ReadExposure, AddsSpansOfTheSameLightAndLeavesDarkOnesOut) {
  v1::ExposureReport r = one_second(0, 0);
  add_leds(&r, 0, 1e5, 7);
  add_leds(&r, 2e5, 3e5, 7);
  add_leds(&r, 3e5, 4e5, 0);
  v1::PatternSpan* dark = r.add_patterns();
  dark->set_kind(v1::PatternSpan::DARK);
  dark->set_off_us(1e6);
  const Exposure e = read(r);
  ASSERT_EQ(e.contributions.size(), 1u);
  EXPECT_NEAR(e.contributions[0].polarized, 0.4, 1e-12);
}

TEST(ReadExposure, RefusesNonsense) {
  const auto refused = [](const auto& spoil) {
    v1::ExposureReport r = one_second(0, 0);
    v1::LedSpan* span = add_leds(&r, 0, 5e5, 4095);
    spoil(&r, span);
    try {
      read(r);
    } catch (const Error& e) {
      return std::string(e.what()).find("ExposureReport.") != std::string::npos;
    }
    return false;
  };
  using Report = v1::ExposureReport*;
  using Span = v1::LedSpan*;
  EXPECT_TRUE(refused([](Report, Span s) { s->set_codes("short"); }));
  EXPECT_TRUE(refused([](Report, Span s) { s->mutable_codes()->at(1) = '\x7f'; }));
  EXPECT_TRUE(refused([](Report, Span s) { s->set_on_us(std::nan("")); }));
  EXPECT_TRUE(refused([](Report, Span s) { s->set_off_us(2e6); }));
  EXPECT_TRUE(refused([](Report, Span s) { s->set_off_us(-1); }));
  EXPECT_TRUE(refused([](Report r, Span) { r->set_open_us(std::nan("")); }));
  EXPECT_TRUE(refused([](Report r, Span) { r->set_close_us(-1); }));
  EXPECT_TRUE(refused([](Report r, Span) { r->set_camera(2); }));
  EXPECT_TRUE(refused([](Report r, Span) { r->set_led_reference_us(0); }));
  EXPECT_TRUE(refused([](Report r, Span) { r->mutable_analyser(0)->set_to_us(5e5); }));
  EXPECT_TRUE(refused([](Report r, Span) { r->mutable_analyser(0)->set_to_rad(INFINITY); }));
  EXPECT_TRUE(refused([](Report r, Span) { r->add_patterns(); }));
  EXPECT_TRUE(refused([](Report r, Span) {
    v1::PatternSpan* p = r->add_patterns();
    p->set_kind(v1::PatternSpan::FRINGE);
    p->set_index(4);
  }));
}

Camera sensor() {
  Camera c;
  c.saturation = 1;
  c.read_noise = 0.0004;
  c.full_well_electrons = 30000;
  return c;
}

TEST(Sensor, HasTheNoiseThatTheManifestStates) {
  const Camera camera = sensor();
  for (float level : {0.f, 0.2f, 0.8f}) {
    const Image3 even(100, 100, Vec3::all(level));
    const Image3 got = develop(expose(even, camera, 5), camera);
    double sum = 0, squares = 0;
    for (const Vec3& v : got) {
      for (int c = 0; c < 3; ++c) sum += v[c], squares += v[c] * v[c];
    }
    const double n = 30000, mean = sum / n, variance = squares / n - mean * mean;
    const double step = gain_per_dn(camera);
    const double expected = level / 30000.0 + 0.0004 * 0.0004 + step * step / 12;
    EXPECT_NEAR(mean, level, 5 * std::sqrt(expected / n));
    EXPECT_NEAR(variance, expected, 0.05 * expected) << level;
  }
}

TEST(Sensor, ClipsAtItsSaturationAndNotBelow) {
  Camera camera = sensor();
  camera.read_noise = camera.full_well_electrons = 0;
  const Image3 bright(4, 4, Vec3(3.f, 1.f, 0.9f));
  const Image3 got = develop(expose(bright, camera, 1), camera);
  EXPECT_NEAR(got(0, 0)[0], camera.saturation, 1e-6);
  EXPECT_NEAR(got(0, 0)[1], camera.saturation, 1e-6);
  EXPECT_NEAR(got(0, 0)[2], 0.9f, gain_per_dn(camera));
}

TEST(Sensor, RepeatsItselfForTheSameSeed) {
  const Image3 even(8, 8, Vec3::all(0.5f));
  const RawImage a = expose(even, sensor(), 1), b = expose(even, sensor(), 1),
                 c = expose(even, sensor(), 2);
  EXPECT_EQ(a(3, 3), b(3, 3));
  EXPECT_NE(cv::norm(a, c), 0);
}

}  // namespace
}  // namespace lamella::twin
