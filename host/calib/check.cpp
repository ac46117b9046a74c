#include "calib/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <mutex>

#include "base/error.h"
#include "base/parallel.h"
#include "calib/check_figures.h"
#include "calib/receive.h"
#include "io/json.h"
#include "link.pb.h"

namespace lamella {

namespace {

// Below these a fit still runs, and says so; they are where its figures begin to suffer.
constexpr double kMostClipped = 0.01;
constexpr double kLeastLedSignal = 20;
constexpr double kLeastProjectorSignal = 20;
constexpr double kMostBlack = 0.05;
constexpr double kMostClosure = 0.02;
constexpr double kLeastContrast = 0.15;
constexpr double kMostAboveFull = 0.01;
constexpr size_t kLeastPixels = 100;

using Photographs = std::map<const Frame*, Photograph>;

class Checker {
 public:
  explicit Checker(const Session& session) : session_(session) {}

  SessionCheck run() {
    manifest();
    roles();
    photographs();
    labels();
    if (check_.worst() != Grade::kUnusable) figures();
    timing();
    return std::move(check_);
  }

 private:
  void line(Grade grade, const std::string& name, const std::string& text) {
    check_.lines.push_back({grade, name, text, 0, "", 0});
  }

  // Runs `read`; what it complains of becomes a line.
  template <class Read>
  void guarded(const std::string& name, const Read& read) {
    try {
      read();
    } catch (const Error& e) {
      line(Grade::kUnusable, name, e.what());
    }
  }

  void share(const std::string& name, double figure, double most, const std::string& of) {
    const Grade grade = figure <= most ? Grade::kGood : Grade::kPoor;
    check_.lines.push_back(
        {grade, name, fmt::format("{:.2f} % {}, at most {:g} %", 100 * figure, of, 100 * most),
         100 * figure, "%", 100 * most});
  }

  void at_least(const std::string& name, double figure, double least, const std::string& of) {
    const Grade grade = figure >= least ? Grade::kGood : Grade::kPoor;
    check_.lines.push_back({grade, name, fmt::format("{:.2f} {}, at least {:g}", figure, of, least),
                            figure, "", least});
  }

  void manifest() {
    line(Grade::kGood, "manifest",
         fmt::format("\"{}\", {} frames, {} LEDs", session_.subject, session_.frames.size(),
                     session_.stage.leds().size()));
    for (const std::string& warning : session_.warnings) {
      line(Grade::kNote, "manifest", warning);
    }
  }

  void roles() {
    guarded("roles", [&] {
      require_burst(session_);
      line(Grade::kGood, "roles", "every role of the left camera is there");
    });
    if (!session_.right)
      line(Grade::kNote, "roles", "no right camera: depth from the projector alone");
  }

  void photographs() {
    std::vector<std::string> complaints(session_.frames.size());
    std::mutex mutex;
    parallel_for(int(session_.frames.size()), [&](int i) {
      const Frame& frame = session_.frames[size_t(i)];
      try {
        Photograph photograph = read_photograph(session_, frame);
        if (frame.camera != "left") return;  // the figures are the left camera's
        const std::lock_guard lock(mutex);
        photographs_[&frame] = std::move(photograph);
      } catch (const Error& e) {
        complaints[size_t(i)] = e.what();
      }
    });
    size_t readable = 0;
    for (const std::string& complaint : complaints) {
      if (complaint.empty()) ++readable;
      if (!complaint.empty()) line(Grade::kUnusable, "photographs", complaint);
    }
    if (readable < complaints.size()) return;
    line(Grade::kGood, "photographs",
         fmt::format("{} readable, {}x{} pixels, every value finite", readable, session_.left.width,
                     session_.left.height));
  }

  void labels() {
    if (session_.regions_file.empty()) {
      line(Grade::kNote, "regions", "none given: fit makes them itself");
      return;
    }
    guarded("regions", [&] {
      labels_ = read_regions(session_);
      line(Grade::kGood, "regions",
           fmt::format("{} named, none empty",
                       std::max<size_t>(session_.region_names.size(), 1) - 1));
    });
  }

  const Frame& frame(Role role, int index, Analyser analyser) const {
    return *session_.find("left", role, index, analyser);
  }

  Photograph take(Role role, int index, Analyser analyser) {
    return std::move(photographs_.at(&frame(role, index, analyser)));
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
    burst_.finest_fringe = take(Role::kFringe, finest, Analyser::kCross);
    for (int k = 0; k < 4; ++k)
      burst_.stripes[size_t(k)] = take(Role::kStripes, k, Analyser::kCross);
    burst_.pixels = pixels_to_check(labels_, burst_.front_cross.radiance);
  }

  void figures() {
    gather();
    if (burst_.pixels.size() < kLeastPixels) {
      line(Grade::kUnusable, "subject",
           fmt::format("{} pixels of it in the left camera", burst_.pixels.size()));
      return;
    }
    clipping();
    noise();
    light();
  }

  void clipping() {
    const auto& b = burst_;
    share("clipped, LEDs",
          clipped_share(
              {&b.full_parallel, &b.full_cross, &b.gradient[0], &b.gradient[1], &b.gradient[2]},
              b.pixels),
          kMostClipped, "of labelled pixels");
    share("clipped, projector",
          clipped_share({&b.front_parallel, &b.front_cross, &b.finest_fringe, &b.stripes[0],
                         &b.stripes[1], &b.stripes[2], &b.stripes[3]},
                        b.pixels),
          kMostClipped, "of labelled pixels");
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
    check_.lines.push_back({right ? Grade::kGood : Grade::kUnusable, "polarization, " + name,
                            fmt::format("parallel exceeds crossed by {:.1f} %{}", 100 * s,
                                        right ? "" : ": is the analyser the wrong way round?"),
                            100 * s, "%", 0});
  }

  void light() {
    polarization("LEDs", burst_.full_parallel, burst_.full_cross);
    polarization("projector", burst_.front_parallel, burst_.front_cross);
    share("projector black level", black_level(burst_), kMostBlack, "of white");
    share("stripes against FRONT + BLACK", stripe_closure(burst_), kMostClosure, "off, median");
    at_least("finest fringe", fringe_contrast(burst_), kLeastContrast, "contrast, median");
    share("gradients above FULL", gradient_above_full(burst_), kMostAboveFull,
          "of labelled pixels");
  }

  void timing() {
    const fs::path file = session_.path / "timing.json";
    if (!fs::exists(file)) {
      line(Grade::kNote, "timing", "no timing.json: nobody attests it");
      return;
    }
    guarded("timing", [&] {
      v1::TimingEdges timing;
      read_json(file, &timing);
      const auto late =
          std::count_if(timing.edges().begin(), timing.edges().end(), [](const auto& e) {
            return std::abs(e.actual_us() - e.planned_us()) > e.tolerance_us();
          });
      const double largest_us = largest_edge_error_us(timing);
      check_.lines.push_back({late > 0 ? Grade::kPoor : Grade::kGood, "timing",
                              fmt::format("{} edges, largest error {:.1f} us, {} beyond tolerance",
                                          timing.edges_size(), largest_us, late),
                              largest_us, "us", 0});
    });
  }

  const Session& session_;
  SessionCheck check_;
  Photographs photographs_;
  Labels labels_;
  CheckedBurst burst_;
};

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

SessionCheck check_session(const fs::path& path) {
  const Session session = read_session(path);
  return Checker(session).run();
}

}  // namespace lamella
