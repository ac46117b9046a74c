#include "io/session_rig.h"

#include <fmt/format.h>

#include "base/error.h"
#include "io/json.h"
#include "io/rig_message.h"

namespace lamella {

namespace {

void read_cameras(const v1::Rig& rig, const std::string& where, Session* s) {
  bool has_left = false;
  for (int i = 0; i < rig.cameras_size(); ++i) {
    const std::string at = where + ": rig.cameras[" + std::to_string(i) + "]";
    Camera camera = camera_from_message(rig.cameras(i), at);
    if (camera.id == "left" ? has_left : s->right.has_value()) {
      throw_bad_input(at + ".id", "a second camera \"" + camera.id + "\"",
                      "call them left and right");
    }
    if (camera.id == "left") {
      s->left = camera;
      has_left = true;
    } else if (camera.id == "right") {
      s->right = camera;
    } else {
      throw_bad_input(at + ".id", "\"" + camera.id + "\"", "cameras are \"left\" and \"right\"");
    }
  }
  if (!has_left)
    throw_bad_input(where + ": rig.cameras", "no camera with id \"left\"",
                    "call the one with both analysers left");
}

// A pattern is drawn in projector pixels: `value` is refused outside `least` to `most` of them.
void require_px(const std::string& where, const std::string& name, double value, double least,
                double most) {
  if (value >= least && value <= most) return;
  throw_bad_input(where + ": patterns." + name,
                  fmt::format("{:g} where {:g} to {:g} pixels are possible", value, least, most),
                  "state what the projector showed");
}

void require_fringes(const Session& s, const std::string& where) {
  const std::string at = where + ": patterns.fringe.periods";
  double last = 0;
  for (double n : s.patterns.fringe_periods) {
    if (!(n > last))
      throw_bad_input(at, "must be positive and increase from each to the next",
                      "list the coarsest first");
    last = n;
  }
  if (last > 0.5 * s.projector.width) {
    throw_bad_input(
        at, fmt::format("{:g} periods across {} pixels cannot be drawn", last, s.projector.width),
        "at least two pixels a period");
  }
}

void require_stripes(const Session& s, const std::string& where) {
  const double period_px = s.patterns.stripe_period_px;
  require_px(where, "stripes.period_px", period_px, 2, s.projector.width);
  require_px(where, "stripes.shift_px", s.patterns.stripe_shift_px, 1e-3 * period_px,
             0.5 * period_px);
}

void require_dots(const Session& s, const std::string& where) {
  const double pitch_px = s.patterns.dot_pitch_px;
  require_px(where, "dots.pitch_px", pitch_px, 4, s.projector.width);
  require_px(where, "dots.diameter_px", s.patterns.dot_diameter_px, 1, 0.9 * pitch_px);
  for (int i = 0; i < 2; ++i) {
    require_px(where, "dots.offset_px[" + std::to_string(i) + "]", s.patterns.dot_offset_px[i],
               -kMaxImageSide, kMaxImageSide);
  }
}

void read_patterns(const v1::Session& message, const std::string& where, Session* s) {
  const v1::Patterns m = patterns_of(message);
  Patterns& p = s->patterns;
  p.fringe_periods.assign(m.fringe().periods().begin(), m.fringe().periods().end());
  p.stripe_period_px = m.stripes().period_px();
  p.stripe_shift_px = m.stripes().shift_px();
  p.dot_pitch_px = m.dots().pitch_px();
  p.dot_diameter_px = m.dots().diameter_px();
  if (m.dots().offset_px_size() != 2) {
    throw_bad_input(where + ": patterns.dots.offset_px", "expected two numbers",
                    "u and v of one dot's centre");
  }
  p.dot_offset_px = {m.dots().offset_px(0), m.dots().offset_px(1)};
  require_fringes(*s, where);
  require_stripes(*s, where);
  require_dots(*s, where);
}

v1::Patterns default_patterns() {
  const Patterns defaults;
  v1::Patterns m;
  for (double n : defaults.fringe_periods) m.mutable_fringe()->add_periods(n);
  m.mutable_stripes()->set_period_px(defaults.stripe_period_px);
  m.mutable_stripes()->set_shift_px(defaults.stripe_shift_px);
  m.mutable_dots()->set_pitch_px(defaults.dot_pitch_px);
  m.mutable_dots()->set_diameter_px(defaults.dot_diameter_px);
  for (int i = 0; i < 2; ++i) m.mutable_dots()->add_offset_px(defaults.dot_offset_px[i]);
  return m;
}

}  // namespace

v1::Patterns patterns_of(const v1::Session& message) {
  const v1::Patterns& given = message.patterns();
  v1::Patterns patterns = default_patterns();
  if (given.fringe().periods_size() > 0) patterns.mutable_fringe()->clear_periods();
  if (given.dots().offset_px_size() > 0) patterns.mutable_dots()->clear_offset_px();
  patterns.MergeFrom(given);
  return patterns;
}

void rig_from_message(const v1::Session& m, const std::string& where, Session* s) {
  if (m.format() != "lamella.session.v1") {
    throw_bad_input(where + ": format", "\"" + m.format() + "\"",
                    "this program reads lamella.session.v1");
  }
  if (!m.has_rig()) throw_bad_input(where + ": rig", "missing", "state it");
  s->stage = LightStage(leds_from_message(m.rig(), where + ": rig"));
  read_cameras(m.rig(), where, s);
  if (!m.rig().has_projector()) throw_bad_input(where + ": rig.projector", "missing", "state it");
  s->projector = camera_from_message(m.rig().projector(), where + ": rig.projector");
  if (m.rig().projector_to_led_size() > 0) {
    s->projector_to_led =
        colour_matrix_from(m.rig().projector_to_led(), where + ": rig.projector_to_led");
  }
  read_patterns(m, where, s);
}

v1::Session calibration_from(const std::string& json, const std::string& where, Session* session) {
  v1::Session manifest;
  parse_json(json, where, &manifest);
  rig_from_message(manifest, where, session);
  return manifest;
}

}  // namespace lamella
