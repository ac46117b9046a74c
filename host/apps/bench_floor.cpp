#include "apps/bench_floor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/bench_floor_steps.h"
#include "apps/bench_noise.h"
#include "apps/compare_folders.h"
#include "base/error.h"
#include "base/progress.h"
#include "fit/report.h"
#include "io/json.h"

namespace lamella::apps {

namespace {

// Near the session's own, as an estimator that weighs by the noise obeys the law of squares only
// for a while.
constexpr double kAddedLevels[] = {M_SQRT2, 2};

std::vector<double> step_figures(const KnownScene& scene, const FloorStep& step,
                                 const fs::path& scratch) {
  fit::LayeredFit fit;
  fit::start_report(scene.burst, &fit);
  step.run(scene, &fit);
  const fs::path folder = scratch / "step";
  fs::create_directory(folder);
  write_layer_maps(folder, fit.maps);
  write_json(folder / "layers.json", fit.layers);
  const std::vector<double> figures = figures_of(compare_folders(folder, scene.truth.folder));
  fs::remove_all(folder);
  return figures;
}

const FloorStep& step_of(size_t figure) { return step_of_figure(bench_figures()[figure].name); }

// The photographs of one session through every step that is asked for.
class FloorRun {
 public:
  FloorRun(const FloorPlan& plan, const std::vector<double>& fit_figures, const fs::path& scratch)
      : scratch_(scratch), progress_("floors", int(plan.quieter.size()) + 1 + added(plan)) {
    for (const size_t figure : plan.figures) {
      const FloorStep& step = step_of(figure);
      floors_.push_back({figure, step.given, fit_figures[figure], {}});
      if (std::find(steps_.begin(), steps_.end(), &step) == steps_.end()) steps_.push_back(&step);
    }
  }

  // `session` holds photographs with `noise` times the noise.
  void measure(const Session& session, const fs::path& truth, double noise) {
    const KnownScene scene = know_scene(session, truth);
    for (const FloorStep* step : steps_) {
      const std::vector<double> figures = step_figures(scene, *step, scratch_);
      for (Floor& floor : floors_) {
        if (&step_of(floor.figure) == step) add(noise, figures[floor.figure], &floor.levels);
      }
    }
    progress_.advance(++done_);
  }

  const std::vector<Floor>& floors() const { return floors_; }

 private:
  static int added(const FloorPlan& plan) { return int(std::size(kAddedLevels)) * plan.draws; }

  static void add(double noise, double error, std::vector<FloorLevel>* levels) {
    const auto at = std::find_if(levels->begin(), levels->end(),
                                 [&](const FloorLevel& level) { return level.noise == noise; });
    if (at != levels->end()) {
      at->errors.push_back(error);
    } else {
      levels->push_back({noise, {error}});
    }
  }

  fs::path scratch_;
  Progress progress_;
  int done_ = 0;
  std::vector<Floor> floors_;
  std::vector<const FloorStep*> steps_;
};

// What a quieter session is asked to share with the one at hand.
void require_same_subject(const Session& quieter, const Session& session) {
  const std::string where = (quieter.path / "session.json").string();
  if (quieter.subject != session.subject) {
    throw_bad_input(where,
                    "its subject is \"" + quieter.subject + "\", not \"" + session.subject + "\"",
                    "give one of the same subject");
  }
  if (quieter.left.width != session.left.width || quieter.left.height != session.left.height) {
    throw_bad_input(where, "its photographs are of another size",
                    "take it again with the same --scale");
  }
  if (!(noise_against(quieter, session) < 1)) {
    throw_bad_input(where, "its camera is not quieter", "give one of less noise");
  }
}

std::string reach_text(v1::BenchFloor::Verdict verdict) {
  switch (verdict) {
    case v1::BenchFloor::REACHED:
      return "reached";
    case v1::BenchFloor::NOT_REACHED:
      return "not reached";
    case v1::BenchFloor::MODEL_ERROR:
      return "model error";
    default:
      return "not known";
  }
}

}  // namespace

double FloorLevel::error() const { return median(errors); }

double NoiseLaw::noise_share() const {
  const double noise = due_to_noise * due_to_noise, all = model * model + noise;
  return all > 0 ? noise / all : kNaN;
}

NoiseLaw noise_law(const std::vector<FloorLevel>& levels) {
  // Normal equations of weight x (a + b n - e), n and e squares, weight 1/e.
  double w = 0, wn = 0, wnn = 0, we = 0, wne = 0;
  for (const FloorLevel& level : levels) {
    const double n = level.noise * level.noise, e = level.error() * level.error();
    const double weight = 1 / std::max(e * e, 1e-24);
    w += weight, wn += weight * n, wnn += weight * n * n;
    we += weight * e, wne += weight * n * e;
  }
  const double determinant = w * wnn - wn * wn;
  double model = (we * wnn - wne * wn) / determinant, noise = (w * wne - wn * we) / determinant;
  if (model < 0) model = 0, noise = wne / wnn;
  if (noise < 0) noise = 0, model = we / w;
  return {std::sqrt(model), std::sqrt(noise)};
}

double Floor::floor() const {
  for (const FloorLevel& level : levels) {
    if (level.noise == 1) return level.error();
  }
  return kNaN;
}

v1::BenchFloor::Verdict Floor::verdict() const {
  const double noise_share = noise_law(levels).noise_share();
  if (!std::isfinite(ratio()) || !std::isfinite(noise_share)) return v1::BenchFloor::NOT_KNOWN;
  if (noise_share < kLeastNoiseShare) return v1::BenchFloor::MODEL_ERROR;
  return ratio() <= kReachedRatio ? v1::BenchFloor::REACHED : v1::BenchFloor::NOT_REACHED;
}

std::vector<size_t> figures_named(const std::vector<std::string>& names) {
  const std::vector<BenchFigure>& figures = bench_figures();
  std::vector<size_t> chosen;
  std::string known = "all";
  for (const BenchFigure& figure : figures) known += std::string(", ") + figure.name;
  for (const std::string& name : names) {
    const size_t before = chosen.size();
    for (size_t i = 0; i < figures.size(); ++i) {
      const std::string label = figures[i].label;
      if (name == "all" || name == figures[i].name || name == label ||
          name == label.substr(0, label.find(','))) {
        chosen.push_back(i);
      }
    }
    if (chosen.size() == before) {
      throw_bad_input("--floor", "no figure \"" + name + "\"", "one of " + known);
    }
  }
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  return chosen;
}

void require_floors(const FloorPlan& plan, const Session& session) {
  if (plan.figures.empty()) return;
  require_noise(session);
  for (const Session& quieter : plan.quieter) require_same_subject(quieter, session);
  read_truth(session.path / "truth", session);
}

std::vector<Floor> run_floors(const Session& session, const FloorPlan& plan,
                              const std::vector<double>& fit_figures, const fs::path& scratch) {
  fs::create_directory(scratch);
  FloorRun run(plan, fit_figures, scratch);
  for (const Session& quieter : plan.quieter) {
    run.measure(quieter, quieter.path / "truth", noise_against(quieter, session));
  }
  run.measure(session, session.path / "truth", 1);
  for (const double noise : kAddedLevels) {
    for (int draw = 0; draw < plan.draws; ++draw) {
      const fs::path folder = scratch / "noisier";
      fs::create_directory(folder);
      run.measure(noisier_session(session, noise, uint64_t(draw), folder), session.path / "truth",
                  noise);
      fs::remove_all(folder);
    }
  }
  fs::remove_all(scratch);
  return run.floors();
}

std::string floor_csv(const std::vector<Floor>& floors) {
  std::string text = "figure,unit,given,fit,floor,ratio,without_noise,noise_share,verdict";
  if (floors.empty()) return text + "\n";
  for (const FloorLevel& level : floors[0].levels) {
    text += fmt::format(",at_noise_{:.3g}", level.noise);
  }
  text += "\n";
  for (const Floor& floor : floors) {
    const BenchFigure& figure = bench_figures()[floor.figure];
    const NoiseLaw law = noise_law(floor.levels);
    text += fmt::format("{},{},\"{}\",{},{},{},{},{},{}", figure.name, figure.unit, floor.given,
                        csv_number(floor.error), csv_number(floor.floor()),
                        csv_number(floor.ratio()), csv_number(law.model),
                        csv_number(law.noise_share()), reach_text(floor.verdict()));
    for (const FloorLevel& level : floor.levels) text += "," + csv_number(level.error());
    text += "\n";
  }
  return text;
}

v1::BenchFloor message_from_floor(const Floor& floor) {
  const NoiseLaw law = noise_law(floor.levels);
  v1::BenchFloor out;
  out.set_figure(bench_figures()[floor.figure].name);
  out.set_unit(bench_figures()[floor.figure].unit);
  out.set_given(floor.given);
  if (std::isfinite(floor.error)) out.set_error(floor.error);
  if (std::isfinite(floor.floor())) out.set_floor(floor.floor());
  if (std::isfinite(floor.ratio())) out.set_ratio(floor.ratio());
  if (std::isfinite(law.model)) out.set_without_noise(law.model);
  if (std::isfinite(law.noise_share())) out.set_noise_share(law.noise_share());
  out.set_verdict(floor.verdict());
  for (const FloorLevel& level : floor.levels) {
    v1::BenchFloor::Level* to = out.add_levels();
    to->set_noise(level.noise);
    for (const double error : level.errors) {
      if (std::isfinite(error)) to->add_errors(error);
    }
  }
  return out;
}

std::string floor_table(const std::vector<Floor>& floors) {
  if (floors.empty()) return "";
  const auto row = [](const std::string& name, const std::vector<std::string>& cells) {
    std::string line = fmt::format("{:<26}", name);
    for (const std::string& cell : cells) line += fmt::format("{:>13}", cell);
    return line + "\n";
  };
  std::vector<std::string> heads{"fit", "floor", "fit / floor", "no noise", "due to noise"};
  for (const FloorLevel& level : floors[0].levels) {
    if (level.noise != 1) heads.push_back(fmt::format("{:.2g} x noise", level.noise));
  }
  heads.push_back("verdict");
  std::string text = row("figure", heads), given;
  for (const Floor& floor : floors) {
    if (given != floor.given) text += "with true " + floor.given + ":\n";
    given = floor.given;
    const NoiseLaw law = noise_law(floor.levels);
    const auto shown = [&](double value) {
      return with_unit(value, bench_figures()[floor.figure].unit);
    };
    const auto known = [](double value, const std::string& text) {
      return std::isfinite(value) ? text : "-";
    };
    std::vector<std::string> cells{shown(floor.error), shown(floor.floor()),
                                   known(floor.ratio(), fmt::format("{:.2f}", floor.ratio())),
                                   shown(law.model), with_unit(law.noise_share(), "")};
    for (const FloorLevel& level : floor.levels) {
      if (level.noise != 1) cells.push_back(shown(level.error()));
    }
    cells.push_back(reach_text(floor.verdict()));
    text += row(std::string("  ") + bench_figures()[floor.figure].label, cells);
  }
  return text;
}

}  // namespace lamella::apps
