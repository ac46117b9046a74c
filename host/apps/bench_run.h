// Seconds against error, for every setting of every knob.
#pragma once

#include "apps/bench_knobs.h"
#include "apps/bench_peers.h"
#include "apps/compare_confidence.h"
#include "io/session.h"

namespace lamella::apps {

struct BenchPoint {
  std::string knob, value;
  fit::Quality quality;
  std::vector<double> seconds;  // of every round: reading, fitting and writing of one fit
  std::vector<double> figures;  // as bench_figures()
};

// What else a machine does adds to seconds and takes nothing away: of several rounds the least
// tells most.
struct Bench {
  std::vector<double> default_seconds;  // of every round
  std::vector<double> default_figures;
  std::vector<BenchPoint> points;
  std::vector<Peer> peers;
  std::vector<ConfidenceCurve> confidence;  // of the default's fit

  double default_least_seconds() const;
  double relative_seconds(const BenchPoint& point) const;  // of the default's
};

struct BenchPlan {
  std::vector<Knob> knobs;
  int rounds = 3;
  bool with_peers = false;
};

// Fits `session` once a round with every setting of the knobs and with the defaults, and has the
// peers do it, all of a round by turns, so that a machine that is slower for a while slows all of
// them; holds each against `session`/truth. Fits lie in `scratch`, one at a time. Throws Error
// where there is no truth.
Bench run_bench(const Session& session, const BenchPlan& plan, const fs::path& scratch);

// The table as text for programs. Columns have their units in their names.
std::string bench_csv(const Bench& bench);
v1::Bench message_from_bench(const Bench& bench, const Session& session);

// For people: a line a setting.
std::string bench_table(const Bench& bench);

}  // namespace lamella::apps
