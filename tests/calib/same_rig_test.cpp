#include "calib/same_rig.h"

#include <gtest/gtest.h>

#include <functional>

#include "base/error.h"
#include "io/fake_session.h"

namespace lamella {
namespace {

v1::Session calibration() { return testing::fake_calibration({24, 32}); }

v1::Welcome shown() { return rig_of(calibration()); }

std::string refusal(const v1::Welcome& welcome, const v1::Session& session) {
  try {
    require_same_rig(welcome, session);
  } catch (const Error& e) {
    EXPECT_EQ(e.fault(), Fault::kRig);
    return e.what();
  }
  return "";
}

TEST(SameRig, HasAsManyLedsAsItsCalibration) {
  v1::Welcome fewer = shown();
  fewer.set_led_count(fewer.led_count() - 1);
  EXPECT_NE(refusal(fewer, calibration()).find("LEDs, its calibration (rig.leds) "),
            std::string::npos);
}

TEST(SameRig, OfACalibrationSaysWhatThatOneSays) {
  v1::Session other = calibration();
  other.mutable_patterns()->mutable_fringe()->add_periods(99);
  other.mutable_patterns()->mutable_dots()->set_offset_px(1, 401);
  EXPECT_EQ(refusal(rig_of(other), other), "");
  EXPECT_NE(refusal(rig_of(other), calibration()), "");
  other.clear_patterns();
  EXPECT_EQ(refusal(rig_of(other), other), "");
}

TEST(ShownPatterns, AreAcceptedWhereTheyAreTheCalibrations) {
  EXPECT_EQ(refusal(shown(), calibration()), "");
}

TEST(ShownPatterns, OfACalibrationThatLeavesThemOutAreTheDefaults) {
  v1::Session bare = calibration();
  bare.clear_patterns();
  EXPECT_EQ(refusal(shown(), bare), "");
  v1::Welcome other = shown();
  other.mutable_patterns()->mutable_stripes()->set_period_px(12);
  EXPECT_NE(
      refusal(other, bare).find("shows patterns.stripes.period_px 12, its calibration says 8"),
      std::string::npos);
}

TEST(ShownPatterns, ThatDifferInAnyNumberAreRefusedByItsName) {
  using Spoil = std::function<void(v1::Welcome*)>;
  const std::pair<const char*, Spoil> cases[] = {
      {"patterns.fringe.periods[2]",
       [](v1::Welcome* w) { w->mutable_patterns()->mutable_fringe()->set_periods(2, 17); }},
      {"patterns.fringe.periods",
       [](v1::Welcome* w) { w->mutable_patterns()->mutable_fringe()->add_periods(99); }},
      {"patterns.stripes.shift_px",
       [](v1::Welcome* w) { w->mutable_patterns()->mutable_stripes()->set_shift_px(1); }},
      {"patterns.dots.pitch_px",
       [](v1::Welcome* w) { w->mutable_patterns()->mutable_dots()->set_pitch_px(53.3); }},
      {"patterns.dots.diameter_px",
       [](v1::Welcome* w) { w->mutable_patterns()->mutable_dots()->set_diameter_px(21); }},
      {"patterns.dots.offset_px[1]",
       [](v1::Welcome* w) { w->mutable_patterns()->mutable_dots()->set_offset_px(1, 401); }},
      {"offset", [](v1::Welcome* w) { w->mutable_patterns()->mutable_dots()->clear_offset_px(); }},
      {"rig.projector.width", [](v1::Welcome* w) { w->set_projector_width(1920); }},
      {"rig.projector.height", [](v1::Welcome* w) { w->set_projector_height(1080); }},
      {"does not say", [](v1::Welcome* w) { w->clear_patterns(); }},
  };
  for (const auto& [name, spoil] : cases) {
    v1::Welcome welcome = shown();
    spoil(&welcome);
    EXPECT_NE(refusal(welcome, calibration()).find(name), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace lamella
