#include "io/fake_session.h"

#include <unistd.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>

#include "calib/receive.h"
#include "io/json.h"
#include "io/rig_message.h"

namespace lamella::testing {

namespace {

constexpr double kRadius_mm = 60;
constexpr double kDistance_mm = 1000;
constexpr float kSaturation = 2.f;
constexpr float kNoise = 1e-4f;

// A camera `yaw_rad` to the right of +Z that looks at the origin; the sphere fills most of it.
Camera looking_at_origin(const std::string& id, cv::Size size, double yaw_rad) {
  Camera c;
  c.id = id;
  c.width = size.width;
  c.height = size.height;
  c.fx = c.fy = 0.4 * size.width * kDistance_mm / kRadius_mm;
  c.cx = 0.5 * (size.width - 1);
  c.cy = 0.5 * (size.height - 1);
  const double s = std::sin(yaw_rad), k = std::cos(yaw_rad);
  c.cam_from_rig = Mat33d(k, 0, -s, 0, -1, 0, -s, 0, -k);
  c.translation_mm = {0, 0, kDistance_mm};
  c.saturation = kSaturation;
  c.read_noise = kNoise;
  c.full_well_electrons = 30000;
  return c;
}

Camera fake_projector() {
  Camera p = looking_at_origin("", {1280, 800}, 0);
  p.fx = p.fy = 3333;
  p.saturation = 1e30;
  p.read_noise = p.full_well_electrons = 0;
  return p;
}

// 24 directions that cover the sphere evenly (a Fibonacci spiral).
std::vector<Led> fake_leds() {
  std::vector<Led> leds;
  for (int i = 0; i < 24; ++i) {
    const double z = 1 - (2 * i + 1) / 24.0, phi = i * 2.39996323, r = std::sqrt(1 - z * z);
    leds.push_back(
        {Vec3(float(r * std::cos(phi)), float(r * std::sin(phi)), float(z)), 0, {1, 1, 1}});
  }
  return leds;
}

// The point of the sphere that pixel (x, y) sees, or nothing.
bool hit_sphere(const Camera& camera, int x, int y, Vec3* point_mm) {
  const Vec3d o = camera.centre_mm(), d = camera.ray(x, y);
  const double b = o.dot(d), c = o.dot(o) - kRadius_mm * kRadius_mm;
  if (b * b < c) return false;
  *point_mm = Vec3(o + d * (-b - std::sqrt(b * b - c)));
  return true;
}

// Irradiance, relative to a white surface at the origin, under the LEDs of a gradient frame.
float led_light(const LightStage& stage, v1::Frame::Role role, const Vec3& n) {
  float e = 0;
  for (size_t i = 0; i < stage.leds().size(); ++i) {
    const Vec3 w = stage.leds()[i].direction;
    const float level = role == v1::Frame::GRADIENT_FULL
                            ? 1.f
                            : gradient_level(w, int(role) - int(v1::Frame::GRADIENT_X));
    e += level * std::max(0.f, dot(n, w)) * stage.irradiance(i, {0, 0, 0})[0];
  }
  return e;
}

struct Scene {
  LightStage stage{fake_leds()};
  Camera projector = fake_projector();
  double coarseness = 1;  // of stripes and dots, against the format's
};

// As many pixels for stripes and dots as a camera of 96 columns has.
double coarseness_for(const Camera& left) { return std::max(1.0, 96.0 / left.width); }

// What the projector sends to column u, row v: between its black level and 1.
float pattern_value(const Scene& scene, const v1::Frame& frame, const cv::Vec2d& uv, int channel) {
  constexpr float kBlack = 0.01f;
  const double u = uv[0], v = uv[1], fine = 1 / scene.coarseness;
  double x = 0;
  switch (frame.role()) {
    case v1::Frame::FRONT:
      x = 1;
      break;
    case v1::Frame::STRIPES:  // as skin blurs them
      x = 0.5 + 0.3 * std::cos(2 * CV_PI * (fine * u - 2.0 * frame.index() - 1.5) / 8);
      break;
    case v1::Frame::FRINGE:
      x = 0.5 +
          0.5 * std::cos(2 * CV_PI * (std::pow(4, frame.index()) * u / 1280 + (channel - 1) / 3.0));
      break;
    case v1::Frame::DOTS: {  // what skin scatters into a dot is missing around it
      const double p = 53.33, du = std::remainder(fine * (u - 640), p),
                   dv = std::remainder(fine * (v - 400), p), r2 = du * du + dv * dv;
      x = r2 < 100 ? 0.3 : r2 < 400 ? 0.9 : 1;
      break;
    }
    default:
      break;
  }
  return kBlack + (1 - kBlack) * float(x);
}

Vec3 radiance(const Scene& scene, const v1::Frame& frame, const Vec3& point_mm) {
  constexpr float kAlbedo[] = {0.6f, 0.4f, 0.3f};
  constexpr float kShine = 0.04f;
  const Vec3 n = unit(point_mm);
  const bool leds = frame.role() <= v1::Frame::GRADIENT_Z;
  const cv::Vec2d uv = scene.projector.project(Vec3d(point_mm));
  const Vec3 way_mm = Vec3(scene.projector.centre_mm()) - point_mm;
  const float falloff = float(kDistance_mm * kDistance_mm) / dot(way_mm, way_mm);
  const float facing = std::max(0.f, dot(n, unit(way_mm)));
  Vec3 rgb;
  for (int c = 0; c < 3; ++c) {
    const float light = leds ? led_light(scene.stage, frame.role(), n)
                             : facing * pattern_value(scene, frame, uv, c);
    const float diffuse = 0.5f * kAlbedo[c] * (leds ? 1.f : falloff);
    // The shine is no surface's, and does not fall off: so a fit sees a lobe in it.
    rgb[c] = light * (diffuse + (frame.analyser() == v1::Frame::PARALLEL ? kShine : 0.f));
  }
  return rgb;
}

Image3 photograph(const Scene& scene, const Camera& camera, const v1::Frame& frame) {
  Image3 image(camera.height, camera.width, Vec3(0, 0, 0));
  cv::RNG noise(frame.step() + 1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      Vec3 point_mm;
      if (hit_sphere(camera, x, y, &point_mm)) image(y, x) = radiance(scene, frame, point_mm);
      for (int c = 0; c < 3; ++c) image(y, x)[c] += float(noise.gaussian(kNoise));
    }
  }
  return image;
}

cv::Mat1b fake_labels(const Camera& camera) {
  cv::Mat1b labels(camera.height, camera.width, uchar(0));
  for (int y = 0; y < labels.rows; ++y) {
    for (int x = 0; x < labels.cols; ++x) {
      Vec3 point_mm;
      if (hit_sphere(camera, x, y, &point_mm)) labels(y, x) = point_mm[1] > -20 ? 1 : 2;
    }
  }
  return labels;
}

void coarsen(double coarseness, v1::Patterns* patterns) {
  v1::StripePattern* stripes = patterns->mutable_stripes();
  stripes->set_period_px(coarseness * stripes->period_px());
  stripes->set_shift_px(coarseness * stripes->shift_px());
  v1::DotPattern* dots = patterns->mutable_dots();
  dots->set_pitch_px(coarseness * dots->pitch_px());
  dots->set_diameter_px(coarseness * dots->diameter_px());
}

v1::Frame frame_of(v1::Frame::Role role, int index, v1::Frame::Analyser analyser, uint32_t step) {
  v1::Frame f;
  f.set_step(step);
  f.set_role(role);
  if (role == v1::Frame::FRINGE || role == v1::Frame::STRIPES) f.set_index(uint32_t(index));
  f.set_analyser(analyser);
  f.set_camera("left");
  f.set_exposure_us(30000);
  f.set_trigger_us(250000.0 * step);
  return f;
}

}  // namespace

v1::Session fake_calibration(cv::Size size) {
  Session session;
  session.subject = "fake";
  session.stage = LightStage(fake_leds());
  session.left = looking_at_origin("left", size, -0.17);
  session.right = looking_at_origin("right", size, 0.17);
  session.projector = fake_projector();
  return message_from_session(session);
}

std::vector<v1::Frame> fake_frames() {
  struct Step {
    v1::Frame::Role role;
    int count;
    bool parallel_too;
  };
  constexpr Step kSteps[] = {{v1::Frame::GRADIENT_FULL, 1, true}, {v1::Frame::GRADIENT_X, 1, true},
                             {v1::Frame::GRADIENT_Y, 1, true},    {v1::Frame::GRADIENT_Z, 1, true},
                             {v1::Frame::FRINGE, 4, false},       {v1::Frame::BLACK, 1, false},
                             {v1::Frame::DOTS, 1, false},         {v1::Frame::FRONT, 1, true},
                             {v1::Frame::STRIPES, 4, false}};
  std::vector<v1::Frame> frames;
  uint32_t step = 0;
  for (const Step& s : kSteps) {
    for (int i = 0; i < s.count; ++i) {
      if (s.parallel_too) frames.push_back(frame_of(s.role, i, v1::Frame::PARALLEL, step++));
      frames.push_back(frame_of(s.role, i, v1::Frame::CROSS, step++));
    }
  }
  std::vector<v1::Frame> right = frames;
  for (v1::Frame& f : right) {
    f.set_camera("right");
    f.set_analyser(v1::Frame::CROSS);
  }
  frames.insert(frames.end(), right.begin(), right.end());
  return frames;
}

void write_fake_session(const fs::path& folder, cv::Size size) {
  v1::Session manifest = fake_calibration(size);
  Scene scene;
  scene.coarseness = coarseness_for(camera_from_message(manifest.rig().cameras(0), "fake"));
  coarsen(scene.coarseness, manifest.mutable_patterns());
  for (v1::Frame frame : fake_frames()) {
    const Camera camera =
        camera_from_message(manifest.rig().cameras(frame.camera() == "left" ? 0 : 1), "fake");
    frame.set_file(frame_file(frame));
    write_exr_rgb(folder / frame.file(), photograph(scene, camera, frame), PixelType::kHalf);
    *manifest.add_frames() = frame;
  }
  const Camera left = camera_from_message(manifest.rig().cameras(0), "fake");
  cv::imwrite((folder / "regions.png").string(), fake_labels(left));
  manifest.mutable_regions()->set_file("regions.png");
  for (const char* name : {"background", "skin", "lips"})
    manifest.mutable_regions()->add_names(name);
  write_json(folder / "session.json", manifest);
}

void leave_out(const fs::path& session, const std::function<bool(const v1::Frame&)>& is_left_out) {
  v1::Session manifest;
  read_json(session / "session.json", &manifest);
  auto& frames = *manifest.mutable_frames();
  frames.erase(std::remove_if(frames.begin(), frames.end(), is_left_out), frames.end());
  write_json(session / "session.json", manifest);
}

ScratchFolder::ScratchFolder() {
  std::string name = (fs::temp_directory_path() / "lamella-test-XXXXXX").string();
  path_ = mkdtemp(name.data());
}

ScratchFolder::~ScratchFolder() { fs::remove_all(path_); }

std::set<std::string> ScratchFolder::contents() const {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(path_)) {
    names.insert(entry.path().lexically_relative(path_).string());
  }
  return names;
}

}  // namespace lamella::testing
