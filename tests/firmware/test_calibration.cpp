#include "test_calibration.h"

#include <sstream>

#include "test_rig.h"

namespace {

std::string leds_text(const struct rig& rig) {
  std::ostringstream text;
  text.precision(17);
  for (size_t i = 0; i < rig.led_count; i++) {
    const double* d = rig.leds[i].direction;
    text << (i > 0 ? ", " : "") << R"({"direction": [)" << d[0] << ", " << d[1] << ", " << d[2]
         << "]}";
  }
  return text.str();
}

std::string view_text(const std::string& id, double width, double height) {
  std::ostringstream text;
  text << R"({"id": ")" << id << R"(", "width": )" << width << R"(, "height": )" << height
       << R"(, "fx": 500, "fy": 501, "cx": 79.5, "cy": 59.5, )"
       << R"("rotation": [1, 0, 0, 0, -1, 0, 0, 0, -1], "translation_mm": [100, 0, 700]})";
  return text.str();
}

std::string patterns_text(const struct rig& rig) {
  std::ostringstream text;
  text.precision(17);
  text << R"({"fringe": {"periods": [)";
  for (int i = 0; i < PATTERN_FRINGES; i++) {
    text << (i > 0 ? ", " : "") << rig.pattern_fringe_periods[i];
  }
  text << R"(]}, "stripes": {"period_px": )" << rig.pattern_stripe_period_px << R"(, "shift_px": )"
       << rig.pattern_stripe_shift_px << R"(}, "dots": {"pitch_px": )" << rig.pattern_dot_pitch_px
       << R"(, "diameter_px": )" << rig.pattern_dot_diameter_px << R"(, "offset_px": [)"
       << rig.pattern_dot_offset_u_px << ", " << rig.pattern_dot_offset_v_px << "]}}";
  return text.str();
}

}  // namespace

std::string calibration_text(int width, int height, const std::string& subject,
                             const std::string& name) {
  const struct rig rig = test_rig(name);
  return R"({"format": "lamella.session.v1", "subject": ")" + subject + R"(",
 "rig": {
  "leds": [)" +
         leds_text(rig) + R"(],
  "cameras": [
   )" + view_text("left", width, height) +
         ",\n   " + view_text("right", width, height) + "],\n  \"projector\": " +
         view_text("projector", rig.projector_width_px, rig.projector_height_px) +
         "},\n \"patterns\": " + patterns_text(rig) + "}\n";
}
