#include "io/rig_message.h"

#include "base/error.h"

namespace lamella {

namespace {

using Values = google::protobuf::RepeatedField<double>;

constexpr double kLargest = 1e9;  // of any number in a calibration: its square is a finite float

void require_finite(double value, const std::string& where) {
  if (!(std::abs(value) <= kLargest))
    throw_bad_input(where, "not a finite, sensible number", "from -1e9 to 1e9");
}

void require_finite(const Values& values, const std::string& where) {
  for (double v : values) require_finite(v, where);
}

void require_count(const Values& values, int count, const std::string& where) {
  if (values.size() != count) {
    throw_bad_input(where,
                    std::to_string(values.size()) + " numbers, expected " + std::to_string(count));
  }
  require_finite(values, where);
}

void require_rotation(const Mat33d& r, const std::string& where) {
  if (cv::norm(r * r.t() - Mat33d::eye()) > 1e-3 || cv::determinant(r) < 0) {
    throw_bad_input(where, "not a rotation", "give an orthonormal right-handed matrix, row-major");
  }
}

double at_most_largest(double value, const std::string& where) {
  if (value > kLargest) throw_bad_input(where, "must be at most 1e9", "state a smaller one");
  return value;
}

double positive(bool given, double value, const std::string& where) {
  if (!given) throw_bad_input(where, "missing", "state it");
  if (!(value > 0)) throw_bad_input(where, "must be a positive number", "state one");
  return at_most_largest(value, where);
}

double not_negative(double value, const std::string& where) {
  if (!(value >= 0)) throw_bad_input(where, "must not be negative", "0 where there is none");
  return at_most_largest(value, where);
}

Vec3 vec3_from(const Values& values, const std::string& where) {
  require_count(values, 3, where);
  return {float(values[0]), float(values[1]), float(values[2])};
}

template <class Vector>
void append(Values* to, const Vector& from) {
  for (int i = 0; i < 3; ++i) to->Add(from[i]);
}

void append(Values* to, const Mat33d& from) {
  for (double v : from.val) to->Add(v);
}

Mat33d matrix_from(const Values& values, const std::string& where) {
  require_count(values, 9, where);
  return Mat33d(values.data());
}

void require_readable_size(const v1::Camera& m, const std::string& where) {
  const double width = positive(m.has_width(), m.width(), where + ".width");
  const double height = positive(m.has_height(), m.height(), where + ".height");
  if (width > kMaxImageSide)
    throw_bad_input(where + ".width", "more than 32768 pixels", "scale the photographs down");
  if (height > kMaxImageSide)
    throw_bad_input(where + ".height", "more than 32768 pixels", "scale the photographs down");
  if (width * height > double(kMaxImagePixels)) {
    throw_bad_input(where + ".width", "with .height, more than 134 million pixels",
                    "scale the photographs down");
  }
}

}  // namespace

Mat33d colour_matrix_from(const Values& values, const std::string& where) {
  constexpr double kSingular = 1e-3;  // smallest singular value over the largest
  const Mat33d matrix = matrix_from(values, where);
  cv::Vec3d singular_values;
  cv::SVD::compute(matrix, singular_values, cv::SVD::NO_UV);
  if (!(singular_values[2] > kSingular * singular_values[0])) {
    throw_bad_input(where, "a matrix that cannot be inverted", "leave it out for the identity");
  }
  const Vec3d grey = matrix * Vec3d(1, 1, 1);
  if (!(grey[0] > 0 && grey[1] > 0 && grey[2] > 0)) {
    throw_bad_input(where, "turns white light black", "leave it out for the identity");
  }
  return matrix;
}

Camera camera_from_message(const v1::Camera& m, const std::string& where) {
  Camera c;
  c.id = m.id();
  require_readable_size(m, where);
  c.width = int(m.width());
  c.height = int(m.height());
  c.fx = positive(m.has_fx(), m.fx(), where + ".fx");
  c.fy = positive(m.has_fy(), m.fy(), where + ".fy");
  if (!m.has_cx()) throw_bad_input(where + ".cx", "missing", "state it");
  if (!m.has_cy()) throw_bad_input(where + ".cy", "missing", "state it");
  require_finite(m.cx(), where + ".cx");
  require_finite(m.cy(), where + ".cy");
  c.cx = m.cx();
  c.cy = m.cy();
  if (m.distortion_size() > 0) {
    require_count(m.distortion(), 5, where + ".distortion");
    for (int i = 0; i < 5; ++i) c.distortion[i] = m.distortion(i);
  }
  c.cam_from_rig = matrix_from(m.rotation(), where + ".rotation");
  require_rotation(c.cam_from_rig, where + ".rotation");
  require_count(m.translation_mm(), 3, where + ".translation_mm");
  c.translation_mm = Vec3d(m.translation_mm().data());
  if (m.has_saturation()) c.saturation = positive(true, m.saturation(), where + ".saturation");
  c.read_noise = not_negative(m.read_noise(), where + ".read_noise");
  c.full_well_electrons = not_negative(m.full_well_electrons(), where + ".full_well_electrons");
  c.extinction = not_negative(m.extinction(), where + ".extinction");
  if (c.extinction > 0.5)
    throw_bad_input(where + ".extinction", "more than half",
                    "state the share of S that leaks into cross, 0 to 0.5");
  return c;
}

v1::Camera message_from_camera(const Camera& c) {
  v1::Camera m;
  m.set_id(c.id);
  m.set_width(unsigned(c.width));
  m.set_height(unsigned(c.height));
  m.set_fx(c.fx);
  m.set_fy(c.fy);
  m.set_cx(c.cx);
  m.set_cy(c.cy);
  for (double k : c.distortion) m.add_distortion(k);
  append(m.mutable_rotation(), c.cam_from_rig);
  append(m.mutable_translation_mm(), c.translation_mm);
  if (c.saturation < 1e29) m.set_saturation(c.saturation);
  if (c.read_noise > 0) m.set_read_noise(c.read_noise);
  if (c.full_well_electrons > 0) m.set_full_well_electrons(c.full_well_electrons);
  if (c.extinction > 0) m.set_extinction(c.extinction);
  return m;
}

std::vector<Led> leds_from_message(const v1::Rig& m, const std::string& where) {
  if (m.leds_size() == 0) throw_bad_input(where + ".leds", "missing", "state it");
  std::vector<Led> leds;
  for (int i = 0; i < m.leds_size(); ++i) {
    const std::string at = where + ".leds[" + std::to_string(i) + "]";
    Led led;
    led.direction = vec3_from(m.leds(i).direction(), at + ".direction");
    if (std::abs(length(led.direction) - 1.f) > 1e-2f) {
      throw_bad_input(at + ".direction", "not a unit vector", "divide it by its length");
    }
    led.direction = unit(led.direction);
    if (m.leds(i).has_distance_mm()) {
      led.distance_mm = float(positive(true, m.leds(i).distance_mm(), at + ".distance_mm"));
    }
    if (m.leds(i).intensity_size() > 0) {
      led.intensity = vec3_from(m.leds(i).intensity(), at + ".intensity");
      for (int c = 0; c < 3; ++c) not_negative(led.intensity[c], at + ".intensity");
    }
    leds.push_back(led);
  }
  return leds;
}

v1::Frame message_from_frame(const Frame& f) {
  v1::Frame m;
  v1::Frame::Role role = v1::Frame::ROLE_UNSPECIFIED;
  v1::Frame::Role_Parse(role_name(f.role), &role);
  v1::Frame::Analyser analyser = v1::Frame::ANALYSER_UNSPECIFIED;
  v1::Frame::Analyser_Parse(analyser_name(f.analyser), &analyser);
  m.set_step(unsigned(f.step));
  m.set_role(role);
  m.set_analyser(analyser);
  if (f.role == Role::kFringe || f.role == Role::kStripes) m.set_index(unsigned(f.index));
  m.set_camera(f.camera);
  m.set_file(f.file);
  m.set_exposure_us(f.exposure_us);
  m.set_trigger_us(f.trigger_us);
  append(m.mutable_radiance_scale(), f.radiance_scale);
  if (f.light_on_us) m.set_light_on_us(*f.light_on_us);
  if (f.light_off_us) m.set_light_off_us(*f.light_off_us);
  if (f.role == Role::kValidation) {
    m.set_view(f.view);
    append(m.mutable_illuminant_to_led(), f.illuminant_to_led);
  }
  return m;
}

v1::Rig message_from_rig(const Session& s) {
  v1::Rig rig;
  for (const Led& led : s.stage.leds()) {
    v1::Led* m = rig.add_leds();
    append(m->mutable_direction(), led.direction);
    if (led.distance_mm > 0) m->set_distance_mm(led.distance_mm);
    if (led.intensity != Vec3(1, 1, 1)) append(m->mutable_intensity(), led.intensity);
  }
  *rig.add_cameras() = message_from_camera(s.left);
  if (s.right) *rig.add_cameras() = message_from_camera(*s.right);
  *rig.mutable_projector() = message_from_camera(s.projector);
  append(rig.mutable_projector_to_led(), s.projector_to_led);
  return rig;
}

v1::Session message_from_session(const Session& s) {
  v1::Session m;
  m.set_format("lamella.session.v1");
  m.set_subject(s.subject);
  *m.mutable_rig() = message_from_rig(s);
  v1::Patterns* p = m.mutable_patterns();
  for (double n : s.patterns.fringe_periods) p->mutable_fringe()->add_periods(n);
  p->mutable_stripes()->set_period_px(s.patterns.stripe_period_px);
  p->mutable_stripes()->set_shift_px(s.patterns.stripe_shift_px);
  p->mutable_dots()->set_pitch_px(s.patterns.dot_pitch_px);
  p->mutable_dots()->set_diameter_px(s.patterns.dot_diameter_px);
  p->mutable_dots()->add_offset_px(s.patterns.dot_offset_px[0]);
  p->mutable_dots()->add_offset_px(s.patterns.dot_offset_px[1]);
  for (const Frame& f : s.frames) *m.add_frames() = message_from_frame(f);
  for (const Frame& f : s.retaken) *m.add_retaken() = message_from_frame(f);
  if (!s.regions_file.empty()) {
    m.mutable_regions()->set_file(s.regions_file);
    for (const std::string& name : s.region_names) m.mutable_regions()->add_names(name);
  }
  return m;
}

}  // namespace lamella
