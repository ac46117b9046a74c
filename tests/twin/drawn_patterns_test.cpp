// What the firmware draws means what the twin shows: two implementations of PROTOCOL.md's patterns.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "proto/twin.pb.h"
#include "twin/drawn_by_firmware.h"
#include "twin/patterns.h"
#include "twin/rig.h"

namespace lamella::twin {
namespace {

std::string rig_file() {
  std::ifstream file(fs::path(LAMELLA_BOARD_DIR) / "sim.rig");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// The rig file's text with one number exchanged.
std::string with(std::string text, const std::string& key, const std::string& value) {
  const size_t at = text.find("\n" + key) + 1;
  return text.replace(at, text.find('\n', at) - at, key + " = " + value);
}

// Code `code` and what lies half a code to both sides must hold the twin's value, in light.
void expect_same(const Image3& wanted, const std::string& rig, v1::PatternSpan::Kind kind,
                 int index) {
  const size_t size[2] = {size_t(wanted.cols), size_t(wanted.rows)};
  const int pattern[2] = {kind, index};
  std::vector<uint32_t> pixels(wanted.total());
  const double gamma = drawn_by_firmware(rig.data(), rig.size(), pattern, size, pixels.data());
  ASSERT_GT(gamma, 0);
  const auto light = [&](double code) { return std::pow(std::clamp(code / 255, 0.0, 1.0), gamma); };
  constexpr double kRounding = 1e-6;  // the twin's values are single precision
  for (int v = 0; v < wanted.rows; ++v) {
    for (int u = 0; u < wanted.cols; ++u) {
      for (int c = 0; c < 3; ++c) {
        const uint32_t code = pixels[size_t(v) * size[0] + size_t(u)] >> (16 - 8 * c) & 255;
        const double value = double(wanted(v, u)[c]);
        ASSERT_GE(value, light(code - 0.5) - kRounding) << u << "," << v << " of " << index;
        ASSERT_LE(value, light(code + 0.5) + kRounding) << u << "," << v << " of " << index;
      }
    }
  }
}

TEST(DrawnPatterns, AreTheTwinsWithinHalfACodeOfLight) {
  const Session rig = make_rig("head", 0.2);
  const std::string file = rig_file();
  for (int k = 0; k < 4; ++k) {
    expect_same(fringe_pattern(rig, k), file, v1::PatternSpan::FRINGE, k);
    expect_same(stripe_pattern(rig, k * rig.patterns.stripe_shift_px), file,
                v1::PatternSpan::STRIPES, k);
  }
  expect_same(dot_pattern(rig), file, v1::PatternSpan::DOTS, 0);
  expect_same(even_pattern(rig, 0), file, v1::PatternSpan::BLACK, 0);
  expect_same(even_pattern(rig, 1), file, v1::PatternSpan::WHITE, 0);
}

TEST(DrawnPatterns, AreTheTwinsWithOddNumbersAndAnotherProjector) {
  Session rig = make_rig("head", 0.2);
  rig.patterns.stripe_period_px = 7.3;
  rig.patterns.stripe_shift_px = 1.37;
  rig.patterns.dot_diameter_px = 13.7;
  rig.patterns.dot_offset_px = {-3.25, 17.1};
  std::string file = with(rig_file(), "pattern.stripe_period_px", "7.3");
  file = with(file, "pattern.stripe_shift_px", "1.37");
  file = with(file, "pattern.dot_diameter_px", "13.7");
  file = with(file, "pattern.dot_offset_u_px", "-3.25");
  file = with(file, "pattern.dot_offset_v_px", "17.1");
  file = with(file, "projector.gamma", "1.7");
  for (int k = 0; k < 4; ++k) {
    expect_same(stripe_pattern(rig, k * rig.patterns.stripe_shift_px), file,
                v1::PatternSpan::STRIPES, k);
  }
  expect_same(dot_pattern(rig), file, v1::PatternSpan::DOTS, 0);
}

}  // namespace
}  // namespace lamella::twin
