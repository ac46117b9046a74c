#include "calib/same_rig.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "io/session_rig.h"

namespace lamella {

namespace {

// JSON and the rig file write decimals: the same number may differ in its last bits.
constexpr double kShownRounding = 1e-9;

constexpr const char* kRepair =
    "make firmware rig file (leds.file, pattern.*, projector.*) and calibration say the same";

[[noreturn]] void reject(const std::string& problem) {
  throw Error(Fault::kRig, "", problem, kRepair);
}

void compare(const std::string& name, double shown, double calibrated) {
  if (std::abs(shown - calibrated) <= kShownRounding * std::abs(calibrated)) return;
  reject(fmt::format("its projector shows {} {:g}, its calibration says {:g}", name, shown,
                     calibrated));
}

void compare_fringes(const v1::FringePattern& shown, const v1::FringePattern& calibrated) {
  compare("patterns.fringe.periods: as many as", shown.periods_size(), calibrated.periods_size());
  for (int i = 0; i < shown.periods_size(); ++i) {
    compare(fmt::format("patterns.fringe.periods[{}]", i), shown.periods(i), calibrated.periods(i));
  }
}

void compare_dots(const v1::DotPattern& shown, const v1::DotPattern& calibrated) {
  compare("patterns.dots.pitch_px", shown.pitch_px(), calibrated.pitch_px());
  compare("patterns.dots.diameter_px", shown.diameter_px(), calibrated.diameter_px());
  if (shown.offset_px_size() != 2) reject("it says no offset of its projector's dots");
  for (int i = 0; i < 2; ++i) {
    compare(fmt::format("patterns.dots.offset_px[{}]", i), shown.offset_px(i),
            calibrated.offset_px(i));
  }
}

}  // namespace

void require_same_rig(const v1::Welcome& welcome, const v1::Session& calibration) {
  const int leds = calibration.rig().leds_size();
  if (int(welcome.led_count()) != leds) {
    reject(fmt::format("it has {} LEDs, its calibration (rig.leds) {}", welcome.led_count(), leds));
  }
  if (!welcome.has_patterns()) reject("does not say which patterns its projector shows");
  const v1::Patterns &shown = welcome.patterns(), calibrated = patterns_of(calibration);
  compare_fringes(shown.fringe(), calibrated.fringe());
  compare("patterns.stripes.period_px", shown.stripes().period_px(),
          calibrated.stripes().period_px());
  compare("patterns.stripes.shift_px", shown.stripes().shift_px(), calibrated.stripes().shift_px());
  compare_dots(shown.dots(), calibrated.dots());
  const v1::Camera& projector = calibration.rig().projector();
  compare("rig.projector.width", welcome.projector_width(), projector.width());
  compare("rig.projector.height", welcome.projector_height(), projector.height());
}

v1::Welcome rig_of(const v1::Session& calibration) {
  v1::Welcome welcome;
  *welcome.mutable_patterns() = patterns_of(calibration);
  welcome.set_led_count(uint32_t(calibration.rig().leds_size()));
  welcome.set_projector_width(calibration.rig().projector().width());
  welcome.set_projector_height(calibration.rig().projector().height());
  return welcome;
}

}  // namespace lamella
