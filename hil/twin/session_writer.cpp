#include "twin/session_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "base/parallel.h"
#include "base/progress.h"
#include "io/json.h"
#include "io/rig_message.h"

namespace lamella::twin {

namespace {

constexpr double kLedExposureUs = 30000, kProjectorExposureUs = 40000, kStepUs = 250000;

struct Step {
  Role role;
  int index;
  Analyser analyser;
};

std::vector<Step> twenty_steps() {
  std::vector<Step> steps;
  for (Role role : {Role::kGradientFull, Role::kGradientX, Role::kGradientY, Role::kGradientZ}) {
    steps.push_back({role, 0, Analyser::kParallel});
    steps.push_back({role, 0, Analyser::kCross});
  }
  for (int i = 0; i < 4; ++i) steps.push_back({Role::kFringe, i, Analyser::kCross});
  steps.push_back({Role::kBlack, 0, Analyser::kCross});
  steps.push_back({Role::kDots, 0, Analyser::kCross});
  steps.push_back({Role::kFront, 0, Analyser::kParallel});
  steps.push_back({Role::kFront, 0, Analyser::kCross});
  for (int i = 0; i < 4; ++i) steps.push_back({Role::kStripes, i, Analyser::kCross});
  return steps;
}

bool is_gradient(Role role) { return role <= Role::kGradientZ; }

LightState light_of(const Session& rig, const Step& step) {
  const auto pattern = [&](v1::PatternSpan::Kind kind) {
    return LightState{.codes = {}, .pattern = kind, .index = uint32_t(step.index)};
  };
  switch (step.role) {
    case Role::kFringe:
      return pattern(v1::PatternSpan::FRINGE);
    case Role::kBlack:
      return pattern(v1::PatternSpan::BLACK);
    case Role::kDots:
      return pattern(v1::PatternSpan::DOTS);
    case Role::kFront:
      return pattern(v1::PatternSpan::WHITE);
    case Role::kStripes:
      return pattern(v1::PatternSpan::STRIPES);
    default:
      break;
  }
  std::vector<float> levels;
  for (const Led& led : rig.stage.leds()) {
    const bool full = step.role == Role::kGradientFull;
    const int axis = int(step.role) - int(Role::kGradientX);
    levels.push_back(full ? 1.f : gradient_level(led.direction, axis));
  }
  return led_state(levels);
}

std::string file_name(int number, const Step& step, const std::string& camera) {
  const bool numbered = step.role == Role::kFringe || step.role == Role::kStripes;
  std::string name =
      fmt::format("frames/{}/{:02}_{}{}_{}.exr", camera, number, role_name(step.role),
                  numbered ? "_" + std::to_string(step.index) : "", analyser_name(step.analyser));
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  return name;
}

void write_frame(const fs::path& folder, const Frame& frame, const Image3& stored) {
  fs::create_directories((folder / frame.file).parent_path());
  write_exr_rgb(folder / frame.file, stored, PixelType::kHalf);
}

}  // namespace

std::vector<Shot> burst(const Session& rig, const std::string& camera) {
  std::vector<Shot> shots;
  int number = 0;
  for (Step step : twenty_steps()) {
    const bool left = camera == "left";
    const bool parallel = left && step.analyser == Analyser::kParallel;
    Shot shot;
    shot.exposure.camera = left ? 0 : 1;
    shot.exposure.contributions = {{light_of(rig, step), parallel ? 1.0 : 0.0, 0.5}};
    Frame& f = shot.frame;
    f.step = number;
    f.role = step.role;
    f.index = step.index;
    f.analyser = parallel ? Analyser::kParallel : Analyser::kCross;
    f.camera = camera;
    f.exposure_us = is_gradient(step.role) ? kLedExposureUs : kProjectorExposureUs;
    f.trigger_us = number * kStepUs + 12000;
    f.radiance_scale = radiance_scale(shot.exposure);
    step.analyser = f.analyser;
    f.file = file_name(number++, step, camera);
    // The right camera's analyser does not move: a second crossed frame would be the same.
    const bool twice = std::any_of(shots.begin(), shots.end(), [&](const Shot& s) {
      return s.frame.role == f.role && s.frame.index == f.index && s.frame.analyser == f.analyser;
    });
    if (!twice) shots.push_back(std::move(shot));
  }
  return shots;
}

void prepare_burst(const Session& rig, Studio* studio) {
  for (const char* camera : {"left", "right"}) {
    std::vector<LightState> lights;
    const std::vector<Shot> shots = burst(rig, camera);
    for (const Shot& shot : shots) {
      const LightState& light = shot.exposure.contributions[0].light;
      if (std::find(lights.begin(), lights.end(), light) == lights.end()) lights.push_back(light);
    }
    studio->prepare(shots[0].exposure.camera, lights);
  }
}

void write_session(const fs::path& folder, const Photographer& photographer, Studio* studio) {
  Session session = photographer.rig();
  prepare_burst(session, studio);
  std::vector<Shot> shots = burst(session, "left");
  for (Shot& shot : burst(session, "right")) shots.push_back(std::move(shot));
  Progress progress("photographs", int(shots.size()));
  for (size_t i = 0; i < shots.size(); ++i) {
    const RawPhotograph photograph = studio->take(shots[i].exposure, i);
    const Camera& camera = session.camera(shots[i].frame.camera);
    write_frame(folder, shots[i].frame, develop(photograph.raw, camera));
    session.frames.push_back(shots[i].frame);
    progress.advance(int(i) + 1);
  }
  write_json(folder / "session.json", message_from_session(session));
}

}  // namespace lamella::twin
