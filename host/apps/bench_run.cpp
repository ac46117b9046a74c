#include "apps/bench_run.h"

#include <fmt/format.h>

#include <optional>

#include "apps/bench_figures.h"
#include "apps/compare_folders.h"
#include "base/error.h"
#include "base/progress.h"
#include "fit/layers.h"
#include "io/json.h"

namespace lamella::apps {

namespace {

OurFit fit_once(const Session& session, const fit::Quality& quality, const fs::path& scratch) {
  fs::remove_all(scratch);
  fs::create_directory(scratch);
  const Stopwatch watch;
  const fit::LayeredFit fit =
      fit::fit_layers(session, fit::Step::kAlbedo, fit::LayerUse::kAuto, quality);
  const double fitted = watch.seconds();
  write_layer_maps(scratch, fit.maps);
  write_json(scratch / "layers.json", fit.layers);
  const double seconds = watch.seconds();
  const Json comparison = compare_folders(scratch, session.path / "truth");
  fs::remove_all(scratch);
  return {seconds, seconds - fitted, figures_of(comparison), confidence_curves_of(comparison)};
}

std::vector<BenchPoint> points_of(const std::vector<Knob>& knobs) {
  std::vector<BenchPoint> points;
  for (const Knob& knob : knobs) {
    for (const BenchSetting& setting : knob.settings) {
      points.push_back({knob.name, setting.value, setting.quality, {}, {}});
    }
  }
  return points;
}

// A fit of the default's settings is the default's: the same seconds and errors stand for both.
void run_round(const Session& session, const fs::path& scratch, Progress* progress, int* done,
               PeerBench* peers, Bench* bench) {
  const OurFit standard = fit_once(session, {}, scratch);
  progress->advance(++*done);
  bench->default_seconds.push_back(standard.seconds);
  bench->default_figures = standard.figures;
  bench->confidence = standard.confidence;
  if (peers) peers->run_round(standard);
  for (BenchPoint& point : bench->points) {
    const bool same = is_default(point.quality);
    const OurFit fit = same ? standard : fit_once(session, point.quality, scratch);
    if (!same) progress->advance(++*done);
    point.seconds.push_back(fit.seconds);
    point.figures = fit.figures;
  }
}

v1::BenchConfidence message_from_curve(const ConfidenceCurve& curve) {
  v1::BenchConfidence out;
  out.set_map(curve.map);
  out.set_error_unit(curve.unit);
  out.set_falls(curve.falls);
  for (const ConfidenceBin& bin : curve.bins) {
    v1::BenchConfidence::Bin* b = out.add_bins();
    b->set_confidence_least(bin.least_confidence);
    b->set_confidence_mean(bin.mean_confidence);
    b->set_pixels(uint32_t(bin.pixels));
    b->set_error_median(bin.median_error);
    b->set_error_p95(bin.p95_error);
  }
  return out;
}

double least(const std::vector<double>& values) {
  return *std::min_element(values.begin(), values.end());
}

}  // namespace

double Bench::default_least_seconds() const { return least(default_seconds); }

double Bench::relative_seconds(const BenchPoint& point) const {
  return least(point.seconds) / default_least_seconds();
}

Bench run_bench(const Session& session, const BenchPlan& plan, const fs::path& scratch) {
  if (!fs::exists(session.path / "truth" / "layers.json")) {
    throw_bad_input((session.path / "truth").string(), "no truth to hold a fit against",
                    "take a session of `lamella twin`");
  }
  Bench bench{{}, {}, points_of(plan.knobs), {}, {}};
  const auto others = std::count_if(bench.points.begin(), bench.points.end(),
                                    [](const BenchPoint& p) { return !is_default(p.quality); });
  std::optional<PeerBench> peers;
  if (plan.with_peers) peers.emplace(session, scratch.parent_path() / "peers");
  Progress progress("fits", plan.rounds * (1 + int(others)));
  int done = 0;
  for (int round = 0; round < plan.rounds; ++round) {
    run_round(session, scratch, &progress, &done, peers ? &*peers : nullptr, &bench);
  }
  if (peers) bench.peers = peers->peers();
  return bench;
}

std::string bench_csv(const Bench& bench) {
  std::string text = "knob,value,default,least_s,median_s,of_default";
  for (const BenchFigure& figure : bench_figures()) text += std::string(",") + figure.name;
  text += "\n";
  for (const BenchPoint& point : bench.points) {
    text += fmt::format("{},{},{:d},{},{},{}", point.knob, point.value, is_default(point.quality),
                        csv_number(least(point.seconds)), csv_number(median(point.seconds)),
                        csv_number(bench.relative_seconds(point)));
    for (const double value : point.figures) text += "," + csv_number(value);
    text += "\n";
  }
  return text;
}

v1::Bench message_from_bench(const Bench& bench, const Session& session) {
  v1::Bench out;
  out.set_format("lamella.bench.v1");
  out.set_pixels(uint32_t(session.left.width) * uint32_t(session.left.height));
  for (const double seconds : bench.default_seconds) out.add_default_seconds_s(seconds);
  for (const BenchPoint& point : bench.points) {
    v1::BenchPoint* p = out.add_points();
    p->set_knob(point.knob);
    p->set_value(point.value);
    *p->mutable_quality() = fit::message_from_quality(point.quality);
    p->set_is_default(is_default(point.quality));
    for (const double seconds : point.seconds) p->add_seconds_s(seconds);
    p->set_of_default(bench.relative_seconds(point));
    for (size_t i = 0; i < point.figures.size(); ++i) {
      if (!std::isfinite(point.figures[i])) continue;
      (*p->mutable_figures())[bench_figures()[i].name] = point.figures[i];
    }
  }
  for (const Peer& peer : bench.peers) *out.add_peers() = message_from_peer(peer);
  for (const ConfidenceCurve& curve : bench.confidence) {
    *out.add_confidence() = message_from_curve(curve);
  }
  return out;
}

// Eight wide; a figure that no region or map tells is a dash.
std::string figure_percent(double share) {
  return std::isfinite(share) ? fmt::format("{:>6.1f} %", 100 * share) : fmt::format("{:>8}", "-");
}

std::string bench_table(const Bench& bench) {
  std::string text = fmt::format("{:<18}{:>10}{:>11}{:>12}{:>15}{:>16}{:>8}{:>8}{:>8}{:>8}\n",
                                 "knob", "value", "seconds", "of default", "position, RMS",
                                 "specular normal", "c", "l_d", "deep", "R(r)");
  for (const BenchPoint& point : bench.points) {
    const std::vector<double>& f = point.figures;
    text +=
        fmt::format("{:<18}{:>10}{:>9.2f} s{:>12.2f}{:>12.3f} mm{:>12.2f} deg{}{}{}{}{}\n",
                    point.knob, point.value, least(point.seconds), bench.relative_seconds(point),
                    f[1], f[2], figure_percent(f[4]), figure_percent(f[8]), figure_percent(f[10]),
                    figure_percent(f[11]), is_default(point.quality) ? "  default" : "");
  }
  return text;
}

}  // namespace lamella::apps
