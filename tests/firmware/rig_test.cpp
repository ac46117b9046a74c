#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>

#include "test_rig.h"

extern "C" {
#include "led_chain.h"
}

namespace {

struct rig_errors errors_of(const std::string& text) {
  struct rig rig;
  struct rig_errors errors;
  rig_parse(text.data(), text.size(), &rig, &errors);
  return errors;
}

struct rig_errors led_errors_of(const std::string& text) {
  struct rig rig;
  struct rig_errors errors = {};
  rig_parse_leds(text.data(), text.size(), &rig, &errors);
  return errors;
}

// A file with the line that begins with `key` replaced; its number goes to `line`.
std::string with_line(const std::string& text, const std::string& key,
                      const std::string& replacement, int* line) {
  const size_t at = text.find("\n" + key) + 1;
  *line = 1 + static_cast<int>(std::count(text.begin(), text.begin() + at, '\n'));
  const size_t end = text.find('\n', at);
  return text.substr(0, at) + replacement + text.substr(end);
}

void expect_first(const struct rig_errors& errors, int line, const std::string& says) {
  ASSERT_GE(errors.count, 1u);
  EXPECT_EQ(errors.list[0].line, line) << errors.list[0].text;
  EXPECT_NE(std::string(errors.list[0].text).find(says), std::string::npos) << errors.list[0].text;
}

void expect_error(const std::string& key, const std::string& replacement, const std::string& says) {
  int line = 0;
  const struct rig_errors errors = errors_of(with_line(rig_file_text(), key, replacement, &line));
  expect_first(errors, line, says);
}

void expect_led_error(const std::string& key, const std::string& replacement,
                      const std::string& says) {
  int line = 0;
  const struct rig_errors errors =
      led_errors_of(with_line(board_text("dome150.leds"), key, replacement, &line));
  expect_first(errors, line, says);
  EXPECT_LE(errors.count, 2u) << "the reader goes on where it was";
  EXPECT_TRUE(errors.list[0].in_leds);
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

TEST(RigFile, WrongKeyNamesItsLineAndTheKeyThatIsMeant) {
  expect_error("leds.spi_hz", "leds.spi_mhz = 10",
               "unknown key 'leds.spi_mhz'; is 'leds.spi_hz' meant?");
  expect_error("camera.iso", "camera_iso = 10", "is 'camera.iso' meant?");
  expect_error("light.least_share", "led.0 = 0 0 0 1 0", "LEDs are listed in leds.file");
}

TEST(RigFile, KeyThatIsLikeNoOtherGetsNoSuggestion) {
  int line = 0;
  const auto errors = errors_of(with_line(rig_file_text(), "camera.iso", "humidity = 4", &line));
  EXPECT_STREQ(errors.list[0].text, "unknown key 'humidity'");
}

TEST(RigFile, EveryWrongKeyIsNamedNotOnlyTheFirst) {
  int first = 0, second = 0, third = 0;
  std::string text = with_line(rig_file_text(), "leds.spi_hz", "leds.spi_mhz = 10", &first);
  text = with_line(text, "camera.guard_us", "camera.guard_us = much", &second);
  text = with_line(text, "analyser.park", "analyser.park = open", &third);
  const struct rig_errors errors = errors_of(text);
  ASSERT_EQ(errors.count, 4u);
  EXPECT_EQ(errors.list[0].line, first);
  EXPECT_EQ(errors.list[1].line, second);
  EXPECT_EQ(errors.list[2].line, third);
  EXPECT_STREQ(errors.list[3].text, "missing key 'leds.spi_hz'");
}

TEST(RigFile, ListOfErrorsIsBoundedAndCountsTheRest) {
  std::string text;
  for (int i = 0; i < 1000; i++) text += "x = 1\n";
  const struct rig_errors errors = errors_of(text);
  EXPECT_GT(errors.count, 1000u);
  EXPECT_EQ(errors.list[RIG_MAX_ERRORS - 1].line, RIG_MAX_ERRORS);
}

TEST(RigFile, NumberOutOfRangeNamesKeyValueAndRange) {
  expect_error("leds.spi_hz", "leds.spi_hz = 20e6", "'leds.spi_hz' is 20000000; it must be");
  expect_error("leds.highest_duty", "leds.highest_duty = 1.5", "'leds.highest_duty'");
}

TEST(RigFile, TextWhereANumberIsDueNamesBoth) {
  expect_error("camera.readout_us", "camera.readout_us = 6 ms", "not '6 ms'");
  expect_error("analyser.park", "analyser.park = open", "not 'open'");
}

TEST(RigFile, NumberThatIsNotDecimalIsRefused) {
  for (const std::string number :
       {"0x10", "0X1p4", "inf", "-infinity", "nan", "NAN(1)", "1e999", ".", "1e", "+-1", "1,5"}) {
    expect_error("camera.guard_us", "camera.guard_us = " + number,
                 "'camera.guard_us' needs one decimal number, not '" + number + "'");
  }
  for (const char* number : {"300", "3e2", "+300.", "3.0E+02", "0300"}) {
    int line = 0;
    const std::string text = with_line(rig_file_text(), "camera.guard_us",
                                       std::string("camera.guard_us = ") + number, &line);
    EXPECT_EQ(errors_of(text).count, 0u) << number;
  }
  int line = 0;
  const std::string text =
      with_line(board_text("vm.rig"), "camera.width_px", "camera.width_px = 0xA0", &line);
  expect_first(errors_of(text), line, "'camera.width_px' needs one decimal number, not '0xA0'");
}

TEST(RigFile, LineThatIsNoPairIsRefused) {
  expect_error("camera.readout_us", "camera.readout_us 6000", "is not 'key = value'");
  const std::string wide = "light.projector_blue_w_per_m2_sr    : 24";
  expect_error("camera.readout_us", wide + "000", "'" + wide + "000' is not 'key = value'");
  expect_error("camera.readout_us", std::string(150, 'x'),
               "'" + std::string(90, 'x') + "...' is not 'key = value'");
}

TEST(RigFile, KeyGivenTwiceIsRefused) {
  expect_error("camera.readout_us", "camera.guard_us = 300", "'camera.guard_us' is given twice");
}

TEST(RigFile, MissingKeyIsNamed) {
  int line = 0;
  expect_first(errors_of(with_line(rig_file_text(), "camera.readout_us", "", &line)), 0,
               "missing key 'camera.readout_us'");
}

TEST(RigFile, LightThatEndsWithinAPwmPeriodNamesItsLineAndWhatWouldDo) {
  expect_error("leds.light_us", "leds.light_us = 30500", "30000 or 31000 would be");
}

// Its every burst would end in a fault of heat as it begins.
TEST(RigFile, RoomThatIsTooHotForAnyLightNamesTheTemperatureThatIsNot) {
  int line = 0;
  const std::string power = with_line(rig_file_text(), "leds.power_w", "leds.power_w = 6", &line);
  const std::string text = with_line(power, "leds.ambient_c", "leds.ambient_c = 34", &line);
  expect_first(errors_of(text), line, "'leds.ambient_c' is 34: above 33 C no LED may shine");
}

TEST(RigFile, ProcessorThatNoBoardHasIsRefused) {
  int line = 0;
  const std::string text = with_line(board_text("pi4.rig"), "linux.cpu", "linux.cpu = 999", &line);
  expect_first(errors_of(text), line, "'linux.cpu' is 999; it must be between 0 and 63");
}

TEST(RigFile, WhatIsNoTextOrTooLongIsOneComplaint) {
  const struct rig_errors binary =
      errors_of(std::string("leds.file = x\n\x7f"
                            "ELF\n\0",
                            19));
  expect_first(binary, 2, "not a text file: it has a byte 0x7F");
  EXPECT_EQ(binary.count, 1u);
  const struct rig_errors longer = errors_of(std::string(RIG_MAX_TEXT_BYTES + 1, '#'));
  expect_first(longer, 0, "longer than 65536 bytes");
  EXPECT_EQ(longer.count, 1u);
  EXPECT_EQ(led_errors_of(std::string("led\x01", 4)).count, 1u);
}

TEST(RigFile, LikeAListOfLedsMayBeginWithAByteOrderMark) {
  const std::string mark = "\xEF\xBB\xBF";
  EXPECT_EQ(errors_of(mark + board_text("sim.rig")).count, 0u);
  EXPECT_EQ(led_errors_of(mark + board_text("dome150.leds")).count, 0u);
  expect_first(led_errors_of(mark + "led.0 0\n"), 1, "'led.0 0' is not 'key = value'");
}

TEST(LedList, IsCountedWithoutAGap) {
  expect_led_error("led.7 ", "led.8 = 0 1 0 0 1", "'led.8' stands where 'led.7' is due");
  expect_led_error("led.7 ", "led.x = 3 9 0 0 1", "'led.x' stands where 'led.7' is due");
}

TEST(LedList, TwoLedsNeverShareAnOutput) {
  expect_led_error("led.7 ", "led.7 = 0 0 0 0 1", "which another LED has");
}

TEST(LedList, DirectionMustBeAUnitVector) {
  expect_led_error("led.7 ", "led.7 = 0 1 0 0 2", "length is not 1");
}

TEST(LedList, LedBeyondTheChainIsRefused) {
  expect_led_error("led.7 ", "led.7 = 7 1 0 0 1", "chips are 0 to 6");
  expect_led_error("led.7 ", "led.7 = 0 24 0 0 1", "outputs 0 to 23");
  for (const char* place : {"0 1 0 0", "0 1 0 0 1 1", "0 1 0 0 0x1", "0 1 0 nan 1", "0.5 1 0 0 1",
                            "0 0x1 0 0 1", "0 1 0 0 1e999", "0 1 0 0-1", "0 1 0 0 1;"}) {
    expect_led_error("led.7 ", std::string("led.7 = ") + place, "needs chip, output, x, y, z");
  }
}

TEST(LedList, ThatIsCutOffOrEmptyIsRefused) {
  expect_first(led_errors_of("# none\n"), 0, "missing key 'led.count'");
  expect_first(led_errors_of("led.count = 2\nled.0 = 0 0 0 1 0\n"), 2,
               "1 LEDs are listed, and 'led.count' on line 1 says 2");
  const std::string list = board_text("dome150.leds");
  const size_t cut = list.find("led.97 ");  // at a line's end, so that every line is sound
  expect_first(led_errors_of(list.substr(0, cut)), 103, "97 LEDs are listed");
}

TEST(LedList, CountIsAWholeNumberGivenOnce) {
  for (const char* count : {"", "0", "169", "150.5", "-1"}) {
    expect_led_error("led.count", std::string("led.count = ") + count,
                     "whole number from 1 to 168");
  }
  expect_led_error("led.0 ", "led.count = 150", "'led.count' is given twice");
}

// The twin computes the same list by the rule in proto/PROTOCOL.md; this is that rule, once more.
TEST(LedList, HasTheGeodesicLedsInTheOrderOfTheProtocol) {
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
