#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>

#include "test_rig.h"

extern "C" {
#include "led_chain.h"
}

namespace {

struct rig_error error_of(const std::string& text) {
  struct rig rig;
  struct rig_error error;
  EXPECT_EQ(rig_parse(text.data(), text.size(), &rig, &error), LAM_BAD_INPUT);
  return error;
}

// The rig file with the line that begins with `key` replaced; its number goes to `line`.
std::string with_line(const std::string& key, const std::string& replacement, int* line) {
  const std::string text = rig_file_text();
  const size_t at = text.find("\n" + key) + 1;
  *line = 1 + static_cast<int>(std::count(text.begin(), text.begin() + at, '\n'));
  const size_t end = text.find('\n', at);
  return text.substr(0, at) + replacement + text.substr(end);
}

void expect_error(const std::string& key, const std::string& replacement, const std::string& says) {
  int line = 0;
  const struct rig_error error = error_of(with_line(key, replacement, &line));
  EXPECT_EQ(error.line, line) << error.text;
  EXPECT_NE(std::string(error.text).find(says), std::string::npos) << error.text;
}

}  // namespace

TEST(RigFile, OfTheSimulatedRigIsReadWhole) {
  const struct rig rig = test_rig();
  EXPECT_EQ(rig.led_count, 150u);
  EXPECT_DOUBLE_EQ(rig_pwm_period_us(&rig), 1000);
  EXPECT_DOUBLE_EQ(rig_shift_us(&rig), 201.6);
  EXPECT_NEAR(rig_projector_light_us(&rig), 33333.33, 0.01);
  EXPECT_FALSE(rig.analyser_parks_crossed);
}

TEST(RigFile, WrongKeyNamesItsLine) {
  expect_error("leds.spi_hz", "leds.spi_mhz = 10", "unknown key 'leds.spi_mhz'");
}

TEST(RigFile, NumberOutOfRangeNamesKeyValueAndRange) {
  expect_error("leds.spi_hz", "leds.spi_hz = 20e6", "'leds.spi_hz' is 20000000; it must be");
  expect_error("camera.guard_us", "camera.guard_us = nan", "'camera.guard_us' is nan");
  expect_error("leds.highest_duty", "leds.highest_duty = 1.5", "'leds.highest_duty'");
}

TEST(RigFile, TextWhereANumberIsDueNamesBoth) {
  expect_error("camera.readout_us", "camera.readout_us = 6 ms", "not '6 ms'");
  expect_error("analyser.park", "analyser.park = open", "not 'open'");
}

TEST(RigFile, LineThatIsNoPairIsRefused) {
  expect_error("camera.readout_us", "camera.readout_us 6000", "is not 'key = value'");
}

TEST(RigFile, KeyGivenTwiceIsRefused) {
  expect_error("camera.readout_us", "camera.guard_us = 300", "'camera.guard_us' is given twice");
}

TEST(RigFile, MissingKeyIsNamed) {
  int line = 0;
  const struct rig_error error = error_of(with_line("camera.readout_us", "", &line));
  EXPECT_EQ(error.line, 0);
  EXPECT_STREQ(error.text, "missing key 'camera.readout_us'");
}

TEST(RigFile, LedsAreCountedWithoutAGap) {
  expect_error("led.7 ", "led.8 = 0 1 0 0 1", "'led.8' stands where 'led.7' is due");
}

TEST(RigFile, TwoLedsNeverShareAnOutput) {
  expect_error("led.7 ", "led.7 = 0 0 0 0 1", "which another LED has");
}

TEST(RigFile, LedDirectionMustBeAUnitVector) {
  expect_error("led.7 ", "led.7 = 0 1 0 0 2", "length is not 1");
}

TEST(RigFile, LedBeyondTheChainIsRefused) {
  expect_error("led.7 ", "led.7 = 7 1 0 0 1", "chips are 0 to 6");
  expect_error("led.7 ", "led.7 = 0 24 0 0 1", "outputs 0 to 23");
}

// The twin computes the same list by the rule in proto/PROTOCOL.md; this is that rule, once more.
TEST(RigFile, ListsTheGeodesicLedsInTheOrderOfTheProtocol) {
  using Point = std::array<double, 3>;
  std::vector<Point> corners = {{0, 1, 0}, {0, -1, 0}};
  const double ring = 2 / std::sqrt(5.0), height = 1 / std::sqrt(5.0);
  for (int k = 0; k < 5; k++) {
    const double azimuth = 2 * M_PI * k / 5;
    const Point p = {ring * std::sin(azimuth), height, ring * std::cos(azimuth)};
    corners.push_back(p);
    corners.push_back({-p[0], -p[1], -p[2]});
  }
  const auto adjacent = [&](size_t a, size_t b) {
    return corners[a][0] * corners[b][0] + corners[a][1] * corners[b][1] +
               corners[a][2] * corners[b][2] >
           0.4;
  };
  std::set<Point> points;
  for (size_t a = 0; a < 12; a++) {
    for (size_t b = a + 1; b < 12; b++) {
      for (size_t c = b + 1; c < 12; c++) {
        if (!adjacent(a, b) || !adjacent(b, c) || !adjacent(a, c)) continue;
        for (int i = 0; i <= 4; i++) {
          for (int j = 0; i + j <= 4; j++) {
            Point p;
            for (int k = 0; k < 3; k++) {
              p[k] = i * corners[a][k] + j * corners[b][k] + (4 - i - j) * corners[c][k];
            }
            const double length = std::hypot(p[0], p[1], p[2]);
            for (double& x : p) x = std::round(x / length * 1e4) / 1e4 + 0.0;
            points.insert(p);
          }
        }
      }
    }
  }
  ASSERT_EQ(points.size(), 162u);
  std::vector<Point> leds(points.begin(), points.end());
  std::sort(leds.begin(), leds.end(), [](auto& a, auto& b) { return a[1] < b[1]; });
  leds.erase(leds.begin(), leds.begin() + 6);
  std::sort(leds.begin(), leds.end(),
            [](auto& a, auto& b) { return a[2] != b[2] ? a[2] > b[2] : a[0] < b[0]; });
  leds.erase(leds.begin(), leds.begin() + 6);
  std::sort(leds.begin(), leds.end(), [](auto& a, auto& b) {
    return a[1] != b[1] ? a[1] > b[1] : std::atan2(a[0], a[2]) < std::atan2(b[0], b[2]);
  });
  const struct rig rig = test_rig();
  for (size_t i = 0; i < rig.led_count; i++) {
    for (int k = 0; k < 3; k++) ASSERT_NEAR(rig.leds[i].direction[k], leds[i][k], 6e-5) << i;
  }
}
