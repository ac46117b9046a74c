#include "twin/session_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>

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

// Where the subject is when: still, or on its way, so that it is where truth has it at the mean of
// the left camera's trigger times.
class Drift {
 public:
  Drift(const Photographer& photographer, const std::vector<Shot>& left)
      : photographer_(photographer) {
    for (const Shot& shot : left) mean_us_ += shot.frame.trigger_us / double(left.size());
    burst_us_ = left.back().frame.trigger_us - left.front().frame.trigger_us;
  }

  bool moves() const { return length(photographer_.drift_mm()) > 0; }

  std::optional<Photographer> at(double trigger_us) const {
    if (!moves()) return std::nullopt;
    return photographer_.moved(photographer_.drift_mm() *
                               float((trigger_us - mean_us_) / burst_us_));
  }

 private:
  const Photographer& photographer_;
  double mean_us_ = 0, burst_us_ = 0;
};

// Indices of the shots that both cameras take at once, in order.
std::vector<std::vector<size_t>> by_step(const std::vector<Shot>& shots) {
  std::map<int, std::vector<size_t>> steps;
  for (size_t i = 0; i < shots.size(); ++i) steps[shots[i].frame.step].push_back(i);
  std::vector<std::vector<size_t>> ordered;
  for (auto& [step, at_once] : steps) ordered.push_back(std::move(at_once));
  return ordered;
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
  std::vector<Shot> shots = burst(session, "left");
  const Drift drift(photographer, shots);
  for (Shot& shot : burst(session, "right")) shots.push_back(std::move(shot));
  if (!drift.moves()) prepare_burst(session, studio);
  Progress progress("photographs", int(shots.size()));
  int done = 0;
  for (const std::vector<size_t>& at_once : by_step(shots)) {
    const std::optional<Photographer> moved = drift.at(shots[at_once[0]].frame.trigger_us);
    std::optional<Studio> elsewhere;
    if (moved) elsewhere.emplace(studio->with(*moved));
    for (size_t i : at_once) {
      const RawPhotograph photograph =
          (elsewhere ? &*elsewhere : studio)->take(shots[i].exposure, i);
      const Camera& camera = session.camera(shots[i].frame.camera);
      write_frame(folder, shots[i].frame, develop(photograph.raw, camera));
      progress.advance(++done);
    }
  }
  for (const Shot& shot : shots) session.frames.push_back(shot.frame);
  write_json(folder / "session.json", message_from_session(session));
}

}  // namespace lamella::twin
