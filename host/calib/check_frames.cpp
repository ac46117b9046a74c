#include "calib/check_frames.h"

#include <fmt/format.h>

#include <array>
#include <map>

#include "calib/check_figures.h"

namespace lamella {

namespace {

constexpr double kMostClipped = 0.01;
constexpr double kHopeless = 0.5;         // of any share that should be next to nothing
constexpr double kLeastLight = 1e-3;      // of a white surface: under it nothing was lit
constexpr double kLeastShare = 0.02;      // of the full light: no pattern has as little
constexpr double kNoisySignal = 5;        // over its noise: this, not light, is what clips
constexpr double kLeastOfColour = 0.005;  // of the colours' mean: no skin reflects as little

// What a frame must not be far below: the whole light that its pattern is a part of.
const Frame* whole_light(const CheckedFrames& in, const Frame& f) {
  const bool leds = f.role <= Role::kGradientZ;
  return in.session.find(f.camera, leds ? Role::kGradientFull : Role::kFront, 0,
                         leds || f.role == Role::kFront ? f.analyser : Analyser::kCross);
}

Vec3 light_in(const CheckedFrames& in, const Frame& f) {
  return mean_light(in.photographs.at(&f), f.camera == "left" ? in.left_pixels : in.right_pixels);
}

// What of the light that a photograph should have it has not: "", "light", "green light".
std::string missing_light(const CheckedFrames& in, const Frame& frame) {
  const Frame* all_of_it = whole_light(in, frame);
  const Vec3 light = light_in(in, frame), whole = light_in(in, *all_of_it);
  if (mean(whole) <= kLeastLight) return &frame == all_of_it ? "light" : "";  // that one is named
  if (mean(light) <= kLeastShare * mean(whole)) return "light";
  for (int c = 0; c < 3; ++c) {
    if (light[c] <= kLeastOfColour * mean(light))
      return kChannelNames[size_t(c)] + std::string(" light");
  }
  return "";
}

// A burst without the others still tells shape, normals and albedos.
bool is_vital(const Session& session, const Frame& f) {
  const int finest = int(session.patterns.fringe_periods.size()) - 1;
  if (f.camera != "left" || f.role == Role::kDots || f.role == Role::kBlack) return false;
  return f.role != Role::kFringe || f.index == finest;
}

// Against clipping. Noise is as large as the signal only where hardly any electron makes it,
// however bright the photograph is.
std::string remedy_for(const CheckedFrames& in, const Frame& frame, bool left) {
  const Camera& camera = left ? in.session.left : *in.session.right;
  const double signal = signal_to_noise(in.photographs.at(&frame), camera, frame,
                                        left ? in.left_pixels : in.right_pixels);
  if (signal == 0 || signal > kNoisySignal) return "expose it less";
  return fmt::format("that is noise (signal / noise {:.2f}): give it more light at less gain",
                     signal);
}

// Of the frames that `belongs` takes: in any of them, and which has most.
template <class Belongs>
CheckLine clipped_in(const CheckedFrames& in, const std::string& name, bool left,
                     const Belongs& belongs) {
  const std::vector<cv::Point>& pixels = left ? in.left_pixels : in.right_pixels;
  std::vector<const Photograph*> all, vital;
  const Frame* worst = nullptr;
  double most = 0;
  for (const auto& [frame, photograph] : in.photographs) {
    if ((frame->camera == "left") != left || !belongs(*frame)) continue;
    all.push_back(&photograph);
    if (is_vital(in.session, *frame)) vital.push_back(&photograph);
    const double figure = clipped_share({&photograph}, pixels);
    if (figure < most || figure == 0) continue;
    if (figure == most && name_of(*worst) < name_of(*frame)) continue;
    worst = frame;
    most = figure;
  }
  CheckLine line = share_line(name, clipped_share(all, pixels), kMostClipped,
                              left ? "of labelled pixels" : "of lit pixels");
  if (line.grade == Grade::kGood) return line;
  if (!(clipped_share(vital, pixels) > kHopeless)) line.grade = Grade::kPoor;
  line.text += fmt::format(", most in {} ({:.2f} %); {}", name_of(*worst), 100 * most,
                           remedy_for(in, *worst, left));
  return line;
}

}  // namespace

std::string name_of(const Frame& frame) {
  std::string name = frame.camera + " " + role_name(frame.role);
  if (frame.role == Role::kFringe || frame.role == Role::kStripes) {
    name += " " + std::to_string(frame.index);
  }
  return name + " " + analyser_name(frame.analyser);
}

CheckLine share_line(const std::string& name, double figure, double most, const std::string& of) {
  Grade grade = figure <= most ? Grade::kGood : Grade::kPoor;
  if (figure > kHopeless) grade = Grade::kUnusable;
  return {
      grade,        name, fmt::format("{:.2f} % {}, at most {:g} %", 100 * figure, of, 100 * most),
      100 * figure, "%",  100 * most};
}

CheckLine check_lit(const CheckedFrames& in) {
  std::map<std::pair<std::string, std::string>, std::vector<std::string>> dark;
  std::map<std::string, size_t> lit_frames;  // that should be, by camera
  for (const auto& [frame, photograph] : in.photographs) {
    if (frame->role == Role::kBlack || frame->role == Role::kAmbient) continue;
    ++lit_frames[frame->camera];
    const std::string missing = missing_light(in, *frame);
    if (!missing.empty()) dark[{missing, frame->camera}].push_back(name_of(*frame));
  }
  std::string text;
  for (const auto& [what, names] : dark) {
    const auto& [missing, camera] = what;
    const bool all = names.size() == lit_frames[camera];
    text += (text.empty() ? "no " : ", no ") + missing + " in ";
    text += all ? "any photograph of the " + camera + " camera"
                : fmt::format("{}", fmt::join(names, ", "));
  }
  if (!dark.empty()) return {Grade::kUnusable, "light", text + "; take the burst again", 0, "", 0};
  return {Grade::kGood, "light", "of every colour in every photograph that should have some", 0,
          "",           0};
}

std::vector<CheckLine> check_clipping(const CheckedFrames& in) {
  const auto by_leds = [](const Frame& f) {
    return f.role <= Role::kGradientZ || f.role == Role::kAmbient;
  };
  const auto by_projector = [&](const Frame& f) { return !by_leds(f); };
  std::vector<CheckLine> lines{clipped_in(in, "clipped, LEDs", true, by_leds),
                               clipped_in(in, "clipped, projector", true, by_projector)};
  if (!in.right_pixels.empty()) {
    const auto any = [](const Frame&) { return true; };
    lines.push_back(clipped_in(in, "clipped, right camera", false, any));
  }
  return lines;
}

}  // namespace lamella
