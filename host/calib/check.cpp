#include "calib/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>

#include "base/error.h"
#include "base/parallel.h"
#include "calib/check_figures.h"
#include "calib/check_frames.h"
#include "calib/check_rig.h"
#include "calib/receive.h"
#include "io/json.h"
#include "io/shortfall.h"
#include "link.pb.h"

namespace lamella {

namespace {

// Below these a fit still runs, and says so; they are where its figures begin to suffer.
constexpr double kLeastLedSignal = 20;
constexpr double kLeastProjectorSignal = 20;
constexpr double kMostBlack = 0.05;
constexpr double kMostClosure = 0.02;
constexpr double kLeastContrast = 0.15;
constexpr double kMostAboveFull = 0.01;
constexpr size_t kLeastPixels = 100;

CheckLine plain_line(Grade grade, const std::string& name, const std::string& text) {
  return {grade, name, text, 0, "", 0};
}

// Runs `read`; what it complains of becomes a line.
template <class Read>
void guarded(const std::string& name, std::vector<CheckLine>* lines, const Read& read) {
  try {
    read();
  } catch (const Error& e) {
    lines->push_back(plain_line(Grade::kUnusable, name, e.what()));
  }
}

// Judges a burst in memory, every photograph of which was read.
class BurstChecker {
 public:
  BurstChecker(const Session& session, const Photographs& photographs, const Labels& labels,
               ShapeFrom shape)
      : session_(session),
        photographs_(photographs),
        labels_(labels),
        has_fringes_(shape == ShapeFrom::kFringes) {}

  std::vector<CheckLine> run() {
    figures();
    return std::move(lines_);
  }

 private:
  void line(Grade grade, const std::string& name, const std::string& text) {
    lines_.push_back(plain_line(grade, name, text));
  }

  void share(const std::string& name, double figure, double most, const std::string& of) {
    lines_.push_back(share_line(name, figure, most, of));
  }

  void at_least(const std::string& name, double figure, double least, const std::string& of) {
    const Grade grade = figure >= least ? Grade::kGood : Grade::kPoor;
    lines_.push_back({grade, name, fmt::format("{:.2f} {}, at least {:g}", figure, of, least),
                      figure, "", least});
  }

  const Frame& frame(Role role, int index, Analyser analyser) const {
    return *session_.find("left", role, index, analyser);
  }

  // A header of the pixels that are there, no copy.
  Photograph take(Role role, int index, Analyser analyser) const {
    return photographs_.at(&frame(role, index, analyser));
  }

  void gather() {
    const int finest = int(session_.patterns.fringe_periods.size()) - 1;
    burst_.full_parallel = take(Role::kGradientFull, 0, Analyser::kParallel);
    burst_.full_cross = take(Role::kGradientFull, 0, Analyser::kCross);
    for (int a = 0; a < 3; ++a) {
      burst_.gradient[size_t(a)] = take(Role(int(Role::kGradientX) + a), 0, Analyser::kCross);
    }
    burst_.front_parallel = take(Role::kFront, 0, Analyser::kParallel);
    burst_.front_cross = take(Role::kFront, 0, Analyser::kCross);
    burst_.black = take(Role::kBlack, 0, Analyser::kCross);
    if (has_fringes_) burst_.finest_fringe = take(Role::kFringe, finest, Analyser::kCross);
    for (int k = 0; k < 4; ++k)
      burst_.stripes[size_t(k)] = take(Role::kStripes, k, Analyser::kCross);
    burst_.pixels = pixels_to_check(labels_, burst_.front_cross.radiance);
    if (has_fringes_ && has_right_geometry(session_)) {
      burst_.right_pixels = pixels_to_check(
          Labels(),
          photographs_.at(session_.find("right", Role::kFront, 0, Analyser::kCross)).radiance);
    }
  }

  void figures() {
    gather();
    if (burst_.pixels.size() < kLeastPixels) {
      line(Grade::kUnusable, "subject",
           fmt::format("{} pixels of it in the left camera, at least {}; label more of it, or take "
                       "it from nearer",
                       burst_.pixels.size(), kLeastPixels));
      return;
    }
    const CheckedFrames frames{session_, photographs_, burst_.pixels, burst_.right_pixels};
    lines_.push_back(check_lit(frames));
    if (lines_.back().grade == Grade::kUnusable) return;
    for (const CheckLine& line : check_clipping(frames)) lines_.push_back(line);
    noise();
    light();
  }

  void signal(const std::string& name, const Photograph& photograph, const Frame& frame,
              double least) {
    const double figure = signal_to_noise(photograph, session_.left, frame, burst_.pixels);
    at_least("signal / noise, " + name, figure, least, "in the weakest channel, median");
  }

  void noise() {
    if (!(session_.left.full_well_electrons > 0)) {
      line(Grade::kNote, "signal / noise", "the manifest gives no full_well_electrons");
      return;
    }
    signal("LEDs parallel", burst_.full_parallel,
           frame(Role::kGradientFull, 0, Analyser::kParallel), kLeastLedSignal);
    signal("LEDs crossed", burst_.full_cross, frame(Role::kGradientFull, 0, Analyser::kCross),
           kLeastLedSignal);
    signal("projector crossed", burst_.front_cross, frame(Role::kFront, 0, Analyser::kCross),
           kLeastProjectorSignal);
  }

  void polarization(const std::string& name, const Photograph& parallel, const Photograph& cross) {
    const double s = polarized_share(parallel, cross, burst_.pixels);
    const bool right = s > 0;
    lines_.push_back({right ? Grade::kGood : Grade::kUnusable, "polarization, " + name,
                      fmt::format("parallel exceeds crossed by {:.1f} %{}", 100 * s,
                                  right ? "" : ": is the analyser the wrong way round?"),
                      100 * s, "%", 0});
  }

  void light() {
    polarization("LEDs", burst_.full_parallel, burst_.full_cross);
    polarization("projector", burst_.front_parallel, burst_.front_cross);
    share("projector black level", black_level(burst_), kMostBlack, "of white");
    share("stripes against FRONT + BLACK", stripe_closure(burst_), kMostClosure, "off, median");
    if (has_fringes_)
      at_least("finest fringe", fringe_contrast(burst_), kLeastContrast, "contrast, median");
    share("gradients above FULL", gradient_above_full(burst_), kMostAboveFull,
          "of labelled pixels");
  }

  const Session& session_;
  const Photographs& photographs_;
  const Labels& labels_;
  const bool has_fringes_;
  std::vector<CheckLine> lines_;
  CheckedBurst burst_;
};

void check_manifest(const Session& s, std::vector<CheckLine>* lines) {
  lines->push_back(plain_line(Grade::kGood, "manifest",
                              fmt::format("\"{}\", {} frames, {} LEDs", s.subject, s.frames.size(),
                                          s.stage.leds().size())));
  for (const std::string& warning : s.warnings) {
    lines->push_back(plain_line(Grade::kNote, "manifest", warning));
  }
  const std::string shortfall = read_shortfall(s.path);
  if (!shortfall.empty()) {
    lines->push_back(plain_line(Grade::kPoor, "burst", "the rig says: " + shortfall));
  }
  guarded("roles", lines, [&] {
    require_burst(s);
    lines->push_back(plain_line(Grade::kGood, "roles", "every role of the left camera is there"));
  });
  if (!s.retaken.empty()) {
    std::string first = name_of(s.retaken.front());
    lines->push_back(plain_line(
        Grade::kNote, "retaken",
        fmt::format("{} photographs were taken again within the burst, the first {}; the ones "
                    "before are kept beside",
                    s.retaken.size(), first)));
  }
  if (!has_right_geometry(s)) {
    const std::string what =
        s.right ? "photographs missing of the right camera" : "no right camera";
    lines->push_back(plain_line(Grade::kNote, "roles", what + ": depth from the projector alone"));
  }
}

// Reads every photograph and keeps those that a fit needs.
Photographs check_photographs(const Session& s, std::vector<CheckLine>* lines) {
  const std::vector<const Frame*> needed = frames_to_fit(s);
  Photographs photographs;
  std::vector<std::string> complaints(s.frames.size());
  std::mutex mutex;
  parallel_for(int(s.frames.size()), [&](int i) {
    const Frame& frame = s.frames[size_t(i)];
    try {
      Photograph photograph = read_photograph(s, frame);
      if (std::find(needed.begin(), needed.end(), &frame) == needed.end()) return;
      const std::lock_guard lock(mutex);
      photographs[&frame] = std::move(photograph);
    } catch (const Error& e) {
      complaints[size_t(i)] = e.what();
    }
  });
  for (size_t i = 0; i < complaints.size(); ++i) {
    if (complaints[i].empty()) continue;
    const bool wanted = std::find(needed.begin(), needed.end(), &s.frames[i]) != needed.end();
    lines->push_back(plain_line(wanted ? Grade::kUnusable : Grade::kNote, "photographs",
                                complaints[i] + (wanted ? "" : "; fit does without it")));
  }
  if (photographs.size() == needed.size()) {
    lines->push_back(
        plain_line(Grade::kGood, "photographs",
                   fmt::format("{} for the fit, {} pixels, every value finite", needed.size(),
                               size_words({s.left.width, s.left.height}))));
  }
  return photographs;
}

Labels check_labels(const Session& s, std::vector<CheckLine>* lines) {
  Labels labels;
  if (s.regions_file.empty()) {
    lines->push_back(plain_line(Grade::kNote, "regions", "none given: fit makes them itself"));
    return labels;
  }
  guarded("regions", lines, [&] {
    labels = read_regions(s);
    const size_t named = std::max<size_t>(s.region_names.size(), 1) - 1;
    lines->push_back(
        plain_line(Grade::kGood, "regions", fmt::format("{} named, none empty", named)));
  });
  return labels;
}

// An analyser that is there early harms nothing.
bool is_beyond_tolerance(const v1::TimedEdge& edge) {
  const double late_us = edge.actual_us() - edge.planned_us();
  return (edge.line() == "ARRIVED" ? late_us : std::abs(late_us)) > edge.tolerance_us();
}

void check_timing(const Session& s, std::vector<CheckLine>* lines) {
  const fs::path file = s.path / "timing.json";
  if (!fs::exists(file)) {
    lines->push_back(plain_line(Grade::kNote, "timing", "no timing.json: nobody attests it"));
    return;
  }
  guarded("timing", lines, [&] {
    v1::TimingEdges timing;
    read_json(file, &timing);
    const auto late = std::count_if(
        timing.edges().begin(), timing.edges().end(),
        [](const v1::TimedEdge& e) { return !e.replaced() && is_beyond_tolerance(e); });
    const double largest_us = largest_edge_error_us(timing, Replaced::kNot);
    lines->push_back({late > 0 ? Grade::kPoor : Grade::kGood, "timing",
                      fmt::format("{} edges, largest error {:.1f} us, {} beyond tolerance",
                                  timing.edges_size(), largest_us, late),
                      largest_us, "us", 0});
  });
}

void append(std::vector<CheckLine>* to, const std::vector<CheckLine>& lines) {
  to->insert(to->end(), lines.begin(), lines.end());
}

}  // namespace

const char* grade_name(Grade grade) {
  constexpr const char* kNames[] = {"good", "note", "poor", "unusable"};
  return kNames[int(grade)];
}

Grade SessionCheck::worst() const {
  Grade worst = Grade::kGood;
  for (const CheckLine& l : lines) worst = std::max(worst, l.grade);
  return worst;
}

const CheckLine* SessionCheck::reason() const {
  for (const CheckLine& l : lines) {
    if (l.grade == Grade::kUnusable) return &l;
  }
  return nullptr;
}

SessionCheck check_burst(const Session& session, const Photographs& photographs,
                         const Labels& labels, ShapeFrom shape) {
  SessionCheck check{check_rig(session, shape)};
  append(&check.lines, BurstChecker(session, photographs, labels, shape).run());
  check_timing(session, &check.lines);
  return check;
}

SessionCheck check_session(const fs::path& path) {
  const Session session = read_session(path);
  SessionCheck check;
  check_manifest(session, &check.lines);
  const Photographs photographs = check_photographs(session, &check.lines);
  const Labels labels = check_labels(session, &check.lines);
  if (check.worst() < Grade::kUnusable) {
    append(&check.lines, check_burst(session, photographs, labels).lines);
  } else {
    append(&check.lines, check_rig(session));
    check_timing(session, &check.lines);
  }
  return check;
}

void require_usable(const SessionCheck& check) {
  const CheckLine* reason = check.reason();
  if (reason) throw Error(Fault::kBadInput, "not usable", reason->name + ": " + reason->text);
}

}  // namespace lamella
