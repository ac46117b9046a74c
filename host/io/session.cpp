#include "io/session.h"

#include <array>
#include <opencv2/imgcodecs.hpp>

#include "base/error.h"
#include "io/json.h"
#include "io/rig_message.h"

namespace lamella {

namespace {

constexpr std::array kRoles = {"GRADIENT_FULL", "GRADIENT_X", "GRADIENT_Y", "GRADIENT_Z",
                               "FRINGE",        "BLACK",      "DOTS",       "FRONT",
                               "STRIPES",       "AMBIENT",    "VALIDATION"};

std::string field(const Session& s, const std::string& name) {
  return (s.path / "session.json").string() + ": " + name;
}

void read_cameras(const v1::Rig& rig, Session* s) {
  bool has_left = false;
  for (int i = 0; i < rig.cameras_size(); ++i) {
    const std::string at = field(*s, "rig.cameras[" + std::to_string(i) + "]");
    Camera camera = camera_from_message(rig.cameras(i), at);
    if (camera.id == "left") {
      s->left = camera;
      has_left = true;
    } else if (camera.id == "right") {
      s->right = camera;
    } else {
      throw_bad_input(at + ".id", "\"" + camera.id + "\"", "cameras are \"left\" and \"right\"");
    }
  }
  if (!has_left) throw_bad_input(field(*s, "rig.cameras"), "no camera with id \"left\"");
}

void read_patterns(const v1::Patterns& m, Session* s) {
  Patterns& p = s->patterns;
  if (m.fringe().periods_size() > 0) {
    p.fringe_periods.assign(m.fringe().periods().begin(), m.fringe().periods().end());
  }
  if (m.stripes().has_period_px()) p.stripe_period_px = m.stripes().period_px();
  if (m.stripes().has_shift_px()) p.stripe_shift_px = m.stripes().shift_px();
  if (m.dots().has_pitch_px()) p.dot_pitch_px = m.dots().pitch_px();
  if (m.dots().has_diameter_px()) p.dot_diameter_px = m.dots().diameter_px();
  if (m.dots().offset_px_size() > 0) {
    if (m.dots().offset_px_size() != 2) {
      throw_bad_input(field(*s, "patterns.dots.offset_px"), "expected two numbers");
    }
    p.dot_offset_px = {m.dots().offset_px(0), m.dots().offset_px(1)};
  }
  for (double n : p.fringe_periods) {
    if (!(n > 0)) throw_bad_input(field(*s, "patterns.fringe.periods"), "must be positive");
  }
  const std::array<std::pair<const char*, double>, 4> lengths{
      {{"stripes.period_px", p.stripe_period_px},
       {"stripes.shift_px", p.stripe_shift_px},
       {"dots.pitch_px", p.dot_pitch_px},
       {"dots.diameter_px", p.dot_diameter_px}}};
  for (const auto& [name, value] : lengths) {
    if (!(value > 0)) throw_bad_input(field(*s, std::string("patterns.") + name), "not positive");
  }
}

Frame frame_from_message(const v1::Frame& m, const std::string& at) {
  if (!m.has_step()) throw_bad_input(at + ".step", "missing");
  if (!m.has_role() || m.role() == v1::Frame::ROLE_UNSPECIFIED) {
    throw_bad_input(at + ".role", "missing");
  }
  if (!m.has_analyser() || m.analyser() == v1::Frame::ANALYSER_UNSPECIFIED) {
    throw_bad_input(at + ".analyser", "missing");
  }
  if (!m.has_camera()) throw_bad_input(at + ".camera", "missing");
  if (!m.has_file()) throw_bad_input(at + ".file", "missing");
  Frame f;
  f.step = int(m.step());
  f.role = Role(int(m.role()) - 1);
  f.index = int(m.index());
  f.analyser = m.analyser() == v1::Frame::CROSS ? Analyser::kCross : Analyser::kParallel;
  f.camera = m.camera();
  f.file = m.file();
  f.exposure_us = m.exposure_us();
  f.trigger_us = m.trigger_us();
  if (m.has_light_on_us()) f.light_on_us = m.light_on_us();
  if (m.has_light_off_us()) f.light_off_us = m.light_off_us();
  f.view = m.view();
  if (m.radiance_scale_size() > 0) {
    if (m.radiance_scale_size() != 3) {
      throw_bad_input(at + ".radiance_scale", "expected three numbers");
    }
    for (int c = 0; c < 3; ++c) {
      f.radiance_scale[c] = float(m.radiance_scale(c));
      if (!(f.radiance_scale[c] > 0) || !is_finite(f.radiance_scale[c])) {
        throw_bad_input(at + ".radiance_scale", "must be positive");
      }
    }
  }
  if (m.illuminant_to_led_size() > 0) {
    f.illuminant_to_led = matrix_from(m.illuminant_to_led(), at + ".illuminant_to_led");
  }
  return f;
}

// The right camera's analyser does not move: of a parallel and a crossed step it takes the same
// photograph twice. AMBIENT and VALIDATION may come in any number.
bool is_duplicate(const Session& s, const Frame& frame) {
  if (frame.role == Role::kValidation || frame.role == Role::kAmbient) return false;
  const Frame* other = s.find(frame.camera, frame.role, frame.index, frame.analyser);
  return other && (frame.camera == "left" || other->step == frame.step);
}

void read_frames(const v1::Session& m, Session* s) {
  for (int i = 0; i < m.frames_size(); ++i) {
    const std::string at = field(*s, "frames[" + std::to_string(i) + "]");
    Frame frame = frame_from_message(m.frames(i), at);
    const bool known = frame.camera == "left" || (frame.camera == "right" && s->right);
    if (!known) throw_bad_input(at + ".camera", "no camera \"" + frame.camera + "\" in the rig");
    const fs::path file = frame.file;
    if (file.is_absolute() || file.lexically_normal().string().starts_with("..")) {
      throw_bad_input(at + ".file", "\"" + frame.file + "\" lies outside the session");
    }
    if (!fs::exists(s->path / file)) {
      throw_bad_input(at + ".file", "no such file: " + (s->path / file).string());
    }
    if (is_duplicate(*s, frame)) {
      throw_bad_input(at + ".role", "a second frame of the same camera, role, index and analyser");
    }
    s->frames.push_back(std::move(frame));
  }
}

void require(const Session& s, Role role, int index, Analyser analyser) {
  if (s.find("left", role, index, analyser)) return;
  std::string name = role_name(role);
  if (role == Role::kFringe || role == Role::kStripes) name += " " + std::to_string(index);
  throw_bad_input(field(s, "frames"),
                  "no " + name + " " + analyser_name(analyser) + " of the left camera",
                  "a burst needs all twenty");
}

}  // namespace

const char* role_name(Role role) { return kRoles[size_t(role)]; }

const char* analyser_name(Analyser analyser) {
  return analyser == Analyser::kCross ? "CROSS" : "PARALLEL";
}

const Camera& Session::camera(const std::string& id) const {
  if (id == "left") return left;
  if (id == "right" && right) return *right;
  throw_bad_input((path / "session.json").string(), "no camera \"" + id + "\"");
}

const Frame* Session::find(const std::string& camera, Role role, int index,
                           Analyser analyser) const {
  for (const Frame& f : frames) {
    if (f.camera == camera && f.role == role && f.index == index && f.analyser == analyser) {
      return &f;
    }
  }
  return nullptr;
}

Session read_session(const fs::path& path) {
  Session s;
  s.path = path;
  if (!fs::is_directory(path)) throw_bad_input(path.string(), "no such session folder");
  v1::Session m;
  for (const std::string& name : read_json(path / "session.json", &m)) {
    s.warnings.push_back(field(s, name) + ": unknown field, ignored");
  }
  if (m.format() != "lamella.session.v1") {
    throw_bad_input(field(s, "format"), "\"" + m.format() + "\"",
                    "this program reads lamella.session.v1");
  }
  if (!m.has_rig()) throw_bad_input(field(s, "rig"), "missing");
  s.subject = m.subject();
  s.stage = LightStage(leds_from_message(m.rig(), field(s, "rig")));
  read_cameras(m.rig(), &s);
  if (!m.rig().has_projector()) throw_bad_input(field(s, "rig.projector"), "missing");
  s.projector = camera_from_message(m.rig().projector(), field(s, "rig.projector"));
  if (m.rig().projector_to_led_size() > 0) {
    s.projector_to_led = matrix_from(m.rig().projector_to_led(), field(s, "rig.projector_to_led"));
  }
  read_patterns(m.patterns(), &s);
  read_frames(m, &s);
  if (m.has_regions()) {
    s.regions_file = m.regions().file();
    s.region_names.assign(m.regions().names().begin(), m.regions().names().end());
  }
  return s;
}

void require_burst(const Session& s) {
  for (Role role :
       {Role::kGradientFull, Role::kGradientX, Role::kGradientY, Role::kGradientZ, Role::kFront}) {
    require(s, role, 0, Analyser::kParallel);
    require(s, role, 0, Analyser::kCross);
  }
  for (size_t i = 0; i < s.patterns.fringe_periods.size(); ++i) {
    require(s, Role::kFringe, int(i), Analyser::kCross);
  }
  for (int i = 0; i < 4; ++i) require(s, Role::kStripes, i, Analyser::kCross);
  require(s, Role::kBlack, 0, Analyser::kCross);
  require(s, Role::kDots, 0, Analyser::kCross);
}

Photograph read_photograph(const Session& session, const Frame& frame) {
  const fs::path file = session.path / frame.file;
  const Camera& camera = session.camera(frame.camera);
  Photograph p;
  p.radiance = read_exr_rgb(file);
  if (p.radiance.cols != camera.width || p.radiance.rows != camera.height) {
    throw_bad_input(file.string(),
                    std::to_string(p.radiance.cols) + "x" + std::to_string(p.radiance.rows) +
                        " pixels, but rig.cameras." + frame.camera + " has " +
                        std::to_string(camera.width) + "x" + std::to_string(camera.height));
  }
  p.clipped = Mask(p.radiance.size(), 0);
  const float saturation = float(camera.saturation);
  for (int y = 0; y < p.radiance.rows; ++y) {
    Vec3* row = p.radiance[y];
    uchar* clipped = p.clipped[y];
    for (int x = 0; x < p.radiance.cols; ++x) {
      Vec3& v = row[x];
      if (!is_finite(v)) {
        throw_bad_input(file.string(), "NaN or infinity at pixel (" + std::to_string(x) + ", " +
                                           std::to_string(y) + ")");
      }
      if (v[0] >= saturation || v[1] >= saturation || v[2] >= saturation) clipped[x] = 255;
      v = v.mul(frame.radiance_scale);
    }
  }
  return p;
}

Labels read_regions(const Session& session) {
  const fs::path file = session.path / session.regions_file;
  cv::Mat image;
  if (fs::exists(file)) image = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
  if (image.empty())
    throw_bad_input(field(session, "regions.file"), "cannot read " + file.string());
  if (image.type() != CV_8UC1) throw_bad_input(file.string(), "not an 8-bit grey label image");
  if (image.cols != session.left.width || image.rows != session.left.height) {
    throw_bad_input(file.string(), "size disagrees with the left camera");
  }
  std::vector<int> count(256, 0);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) ++count[image.at<uchar>(y, x)];
  }
  const size_t named = session.region_names.size();
  for (size_t label = 0; label < 256; ++label) {
    if (label >= std::max<size_t>(named, 1) && count[label] > 0) {
      throw_bad_input(file.string(), "label " + std::to_string(label) + " has no name",
                      "name it in session.json: regions.names");
    }
    if (label > 0 && label < named && count[label] == 0) {
      throw_bad_input(file.string(), "region \"" + session.region_names[label] + "\" is empty",
                      "remove its name or paint it");
    }
  }
  return image;
}

}  // namespace lamella
