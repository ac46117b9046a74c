#include "io/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "base/error.h"
#include "io/json.h"
#include "io/labels.h"
#include "io/rig_message.h"
#include "io/session_rig.h"
#include "io/shortfall.h"

namespace lamella {

namespace {

constexpr std::array kRoles = {"GRADIENT_FULL", "GRADIENT_X", "GRADIENT_Y", "GRADIENT_Z",
                               "FRINGE",        "BLACK",      "DOTS",       "FRONT",
                               "STRIPES",       "AMBIENT",    "VALIDATION"};

constexpr unsigned kLargestStep = 9999;
constexpr double kLongest_us = 1e12;

std::string field(const Session& s, const std::string& name) {
  return (s.path / "session.json").string() + ": " + name;
}

void require_time(double time_us, const std::string& at) {
  if (!(std::abs(time_us) < kLongest_us))
    throw_bad_input(at, "not a time within a burst", "microseconds since the burst began");
}

Frame frame_from_message(const v1::Frame& m, const std::string& at) {
  if (!m.has_step()) throw_bad_input(at + ".step", "missing", "state it");
  if (!m.has_role() || m.role() == v1::Frame::ROLE_UNSPECIFIED) {
    throw_bad_input(at + ".role", "missing", "state it");
  }
  if (!m.has_analyser() || m.analyser() == v1::Frame::ANALYSER_UNSPECIFIED) {
    throw_bad_input(at + ".analyser", "missing", "state it");
  }
  if (!m.has_camera()) throw_bad_input(at + ".camera", "missing", "state it");
  if (!m.has_file()) throw_bad_input(at + ".file", "missing", "state it");
  Frame f;
  if (m.step() > kLargestStep)
    throw_bad_input(at + ".step", "more than 9999", "number steps from 0");
  if (m.index() > kLargestStep)
    throw_bad_input(at + ".index", "more than 9999", "number steps from 0");
  require_time(m.exposure_us(), at + ".exposure_us");
  require_time(m.trigger_us(), at + ".trigger_us");
  require_time(m.light_on_us(), at + ".light_on_us");
  require_time(m.light_off_us(), at + ".light_off_us");
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
      throw_bad_input(at + ".radiance_scale", "expected three numbers",
                      "one each for red, green and blue");
    }
    for (int c = 0; c < 3; ++c) {
      f.radiance_scale[c] = float(m.radiance_scale(c));
      if (!(f.radiance_scale[c] > 0) || !is_finite(f.radiance_scale[c])) {
        throw_bad_input(at + ".radiance_scale", "must be positive",
                        "leave it out where stored values are radiances");
      }
    }
  }
  if (m.illuminant_to_led_size() > 0) {
    f.illuminant_to_led = colour_matrix_from(m.illuminant_to_led(), at + ".illuminant_to_led");
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

// A file that the manifest names must be one, inside the session.
void require_file(const Session& s, const std::string& name, const std::string& at) {
  const fs::path file = fs::path(name).lexically_normal();
  if (file.is_absolute() || (!file.empty() && *file.begin() == "..")) {
    throw_bad_input(at, "\"" + name + "\" lies outside the session",
                    "copy it into the session's folder");
  }
  std::error_code failed;
  if (!fs::is_regular_file(s.path / file, failed)) {
    throw_bad_input(at, "no such file: " + (s.path / file).string(),
                    "copy it there, or name the file that is");
  }
}

Frame checked_frame(const v1::Frame& m, const Session& s, const std::string& at) {
  Frame frame = frame_from_message(m, at);
  const bool known = frame.camera == "left" || (frame.camera == "right" && s.right);
  if (!known)
    throw_bad_input(at + ".camera", "no camera \"" + frame.camera + "\" in the rig",
                    "name one of rig.cameras");
  require_file(s, frame.file, at + ".file");
  if (!frame.view.empty()) require_file(s, frame.view, at + ".view");
  return frame;
}

void read_frames(const v1::Session& m, Session* s) {
  for (int i = 0; i < m.frames_size(); ++i) {
    const std::string at = field(*s, "frames[" + std::to_string(i) + "]");
    Frame frame = checked_frame(m.frames(i), *s, at);
    if (is_duplicate(*s, frame)) {
      throw_bad_input(at + ".role", "a second frame of the same camera, role, index and analyser",
                      "leave one out");
    }
    s->frames.push_back(std::move(frame));
  }
  for (int i = 0; i < m.retaken_size(); ++i) {
    const std::string at = field(*s, "retaken[" + std::to_string(i) + "]");
    s->retaken.push_back(checked_frame(m.retaken(i), *s, at));
  }
}

void read_region_names(const v1::Regions& m, Session* s) {
  if (m.file().empty()) throw_bad_input(field(*s, "regions.file"), "missing", "state it");
  require_file(*s, m.file(), field(*s, "regions.file"));
  s->region_names.assign(m.names().begin(), m.names().end());
  require_region_names(s->region_names, field(*s, "regions.names"));
  s->regions_file = m.file();
}

void require(const Session& s, Role role, int index, Analyser analyser) {
  if (s.find("left", role, index, analyser)) return;
  std::string name = role_name(role);
  if (role == Role::kFringe || role == Role::kStripes) name += " " + std::to_string(index);
  const std::string shortfall = read_shortfall(s.path);
  std::string remedy = shortfall.empty()
                           ? "a burst needs all twenty"
                           : "the rig says: " + shortfall +
                                 "; if no other folder has the burst whole, take it again";
  if (role == Role::kFringe) remedy += ", or give the subject's shape: fit --mesh FILE";
  throw_bad_input(field(s, "frames"),
                  "no " + name + " " + analyser_name(analyser) + " of the left camera", remedy);
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

PixelWindow Session::window(const std::string& camera_id) const {
  const auto found = windows.find(camera_id);
  if (found != windows.end()) return found->second;
  const Camera& whole = camera(camera_id);
  return whole_window({whole.width, whole.height});
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
  if (!fs::is_directory(path))
    throw_bad_input(path.string(), "no such session folder", "is the name right?");
  v1::Session m;
  for (const std::string& name : read_json(path / "session.json", &m)) {
    s.warnings.push_back(field(s, name) + ": unknown field, ignored");
  }
  s.subject = m.subject();
  rig_from_message(m, (path / "session.json").string(), &s);
  read_frames(m, &s);
  if (m.has_regions()) read_region_names(m.regions(), &s);
  return s;
}

void require_burst(const Session& s, ShapeFrom shape) {
  for (Role role :
       {Role::kGradientFull, Role::kGradientX, Role::kGradientY, Role::kGradientZ, Role::kFront}) {
    require(s, role, 0, Analyser::kParallel);
    require(s, role, 0, Analyser::kCross);
  }
  const size_t fringes = shape == ShapeFrom::kMesh ? 0 : s.patterns.fringe_periods.size();
  for (size_t i = 0; i < fringes; ++i) {
    require(s, Role::kFringe, int(i), Analyser::kCross);
  }
  for (int i = 0; i < 4; ++i) require(s, Role::kStripes, i, Analyser::kCross);
  require(s, Role::kBlack, 0, Analyser::kCross);
  require(s, Role::kDots, 0, Analyser::kCross);
}

namespace {

// Most rows have none: looked for without a branch per pixel.
bool has_clipped(const Vec3* row, int pixels, float saturation) {
  const float* values = row->val;
  unsigned clipped = 0;
  for (int i = 0; i < 3 * pixels; ++i) clipped |= unsigned(values[i] >= saturation);
  return clipped != 0;
}

}  // namespace

Photograph read_photograph(const Session& session, const Frame& frame) {
  const fs::path file = session.path / frame.file;
  const Camera& camera = session.camera(frame.camera);
  Photograph p;
  const cv::Size size = exr_size(file);  // before its pixels: they may be very many
  const PixelWindow window = session.window(frame.camera);
  if (size != window.whole) {
    throw_bad_input(file.string(),
                    size_words(size) + " pixels, but the " + frame.camera +
                        " camera (rig.cameras) has " + size_words(window.whole),
                    "correct whichever is wrong");
  }
  p.radiance = read_finite_rgb(file, window.area);
  for (int y = 0; y < p.radiance.rows; ++y) {
    Vec3* row = p.radiance[y];
    const bool any_clipped = has_clipped(row, p.radiance.cols, float(camera.saturation));
    if (any_clipped && p.clipped.empty()) p.clipped = Mask(p.radiance.size(), 0);
    for (int x = 0; any_clipped && x < p.radiance.cols; ++x) {
      const float most = std::max({row[x][0], row[x][1], row[x][2]});
      if (most >= float(camera.saturation)) p.clipped(y, x) = 255;
    }
    if (frame.radiance_scale == Vec3(1, 1, 1)) continue;
    for (int x = 0; x < p.radiance.cols; ++x) row[x] = row[x].mul(frame.radiance_scale);
  }
  return p;
}

namespace {

// Every label has a name, every name has pixels.
void require_named(const Session& session, const fs::path& file, const Labels& labels) {
  std::array<int, 256> count{};
  for (const uchar label : labels) ++count[label];
  const size_t named = session.region_names.size();
  for (size_t label = std::max<size_t>(named, 1); label < count.size(); ++label) {
    if (count[label] == 0) continue;
    throw_bad_input(file.string(), "label " + std::to_string(label) + " has no name",
                    session.given_labels.empty()
                        ? "name it in session.json: regions.names"
                        : "name it in " + file.stem().string() + ".json: names");
  }
  for (size_t label = 1; label < named; ++label) {
    if (count[label] > 0) continue;
    throw_bad_input(file.string(),
                    "region \"" + session.region_names[label] + "\" (regions.names[" +
                        std::to_string(label) + "]) is empty",
                    "remove its name or paint it");
  }
}

}  // namespace

void require_region_names(const std::vector<std::string>& names, const std::string& at) {
  if (names.size() > 256) throw_bad_input(at, "more than 256", "merge some");
  for (size_t i = 0; i < names.size(); ++i) {
    const auto end = names.begin() + std::ptrdiff_t(i);
    const bool twice = std::find(names.begin(), end, names[i]) != end;
    if (!names[i].empty() && !twice) continue;
    throw_bad_input(at + "[" + std::to_string(i) + "]",
                    twice ? "\"" + names[i] + "\" is named twice" : "empty",
                    "name every region once");
  }
}

Labels read_regions(const Session& session) {
  const bool given = !session.given_labels.empty();
  const fs::path file =
      given ? fs::path(session.regions_file) : session.path / session.regions_file;
  const Labels labels = given ? session.given_labels : read_labels(file);
  const PixelWindow window = session.window("left");
  if (labels.size() != window.whole) {
    throw_bad_input(file.string(),
                    size_words(labels.size()) + " pixels, but the left camera (rig.cameras) has " +
                        size_words(window.whole),
                    "label that camera's photographs pixel by pixel");
  }
  require_named(session, file, labels);
  return labels(window.area).clone();
}

}  // namespace lamella
