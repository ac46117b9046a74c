// lamella bench SESSION: what each knob of the fit costs and what it brings, and what an error
// would be at the least.
#include <fmt/format.h>
#include <unistd.h>

#include <memory>

#include "apps/bench_chart.h"
#include "apps/bench_floor.h"
#include "apps/bench_run.h"
#include "apps/commands.h"
#include "apps/process_interrupt.h"
#include "apps/process_killed.h"
#include "apps/report.h"
#include "base/error.h"
#include "fit/binned.h"
#include "io/json.h"
#include "io/whole_file.h"

namespace lamella::apps {

namespace {

struct BenchArguments {
  fs::path session, out;
  std::vector<std::string> knobs, floors, quieter;
  int rounds = 3;
  bool peers = false, json = false;
};

std::vector<Knob> knobs_named(const std::vector<std::string>& names) {
  const std::vector<Knob> all = bench_knobs();
  std::vector<Knob> chosen;
  for (const std::string& name : names) {
    const auto at =
        std::find_if(all.begin(), all.end(), [&](const Knob& knob) { return knob.name == name; });
    if (at == all.end()) {
      std::string known;
      for (const Knob& knob : all) known += (known.empty() ? "" : ", ") + knob.name;
      throw_bad_input("--knob", "no knob \"" + name + "\"", "one of " + known);
    }
    chosen.push_back(*at);
  }
  return chosen;
}

// Everything, unless something is asked for.
BenchPlan bench_plan(const BenchArguments& args) {
  if (args.knobs.empty() && args.floors.empty() && !args.peers) {
    return {bench_knobs(), args.rounds, true};
  }
  const bool has_seconds = !args.knobs.empty() || args.peers;
  return {knobs_named(args.knobs), has_seconds ? args.rounds : 1, args.peers};
}

// A fit takes smaller blocks where those of a setting do not resolve the patterns: such a point
// would be another setting's.
void leave_out_unresolving(const Session& session, std::vector<Knob>* knobs) {
  for (Knob& knob : *knobs) {
    if (knob.name != "bin_px") continue;
    std::erase_if(knob.settings, [&](const BenchSetting& setting) {
      const int asked = setting.quality.bin_px;
      if (fit::resolving_bin_px(session, asked) == asked) return false;
      fmt::print(stderr,
                 "lamella: warning: bin_px {} is left out: such blocks do not resolve the "
                 "patterns\n",
                 asked);
      return true;
    });
  }
}

FloorPlan floor_plan(const BenchArguments& args) {
  FloorPlan plan{figures_named(args.floors), {}, args.rounds};
  if (plan.figures.empty() && !args.quieter.empty()) {
    throw_bad_input("--quieter", "is of --floor", "give --floor with it");
  }
  for (const std::string& folder : args.quieter) plan.quieter.push_back(read_session(folder));
  return plan;
}

// Where nothing is to be kept, files lie in the system's temporary folder meanwhile.
fs::path place_of(const BenchArguments& args) {
  if (!args.out.empty()) return args.out;
  if (args.floors.empty() && !args.peers) {
    throw_bad_input("--out", "is needed", "name a folder for the tables");
  }
  return fs::temp_directory_path() / fmt::format("lamella-bench-{}", getpid());
}

struct BenchResult {
  Bench bench;
  std::vector<Floor> floors;
};

v1::Bench message_from_result(const BenchResult& result, const Session& session) {
  v1::Bench message = message_from_bench(result.bench, session);
  for (const Floor& floor : result.floors) *message.add_floors() = message_from_floor(floor);
  return message;
}

// Returns the names of the files.
std::string write_tables(const BenchResult& result, const BenchPlan& plan, const Session& session,
                         const fs::path& folder) {
  write_json(folder / "bench.json", message_from_result(result, session), Defaults::kWritten);
  std::string names = "bench.json";
  if (!plan.knobs.empty()) {
    write_whole_text(folder / "bench.csv", bench_csv(result.bench));
    names += ", bench.csv";
  }
  if (plan.with_peers) {
    write_whole_text(folder / "peers.csv", peer_csv(result.bench.peers));
    names += ", peers.csv";
  }
  if (!plan.knobs.empty() || plan.with_peers) {
    const std::string title = fmt::format("{}, {} x {} pixels", one_line(session.subject),
                                          session.left.width, session.left.height);
    write_whole_text(folder / "bench.svg",
                     bench_chart(result.bench, plan.knobs, result.floors, title));
    names += ", bench.svg";
  }
  if (!result.floors.empty()) {
    write_whole_text(folder / "floor.csv", floor_csv(result.floors));
    names += ", floor.csv";
  }
  return names;
}

void run_bench_command(const BenchArguments& args) {
  const FloorPlan floors = floor_plan(args);
  BenchPlan plan = bench_plan(args);
  const fs::path place = place_of(args);
  abandon_outputs_on_interrupt();
  const Session session = read_session(args.session);
  require_floors(floors, session);
  leave_out_unresolving(session, &plan.knobs);
  clear_half_written_beside(place);
  WholeFolder folder(place, "bench.json");
  BenchResult result;
  std::string written;
  folder.blame_place([&] {
    result.bench = run_bench(session, plan, folder.path() / "fit");
    if (!floors.figures.empty()) {
      result.floors =
          run_floors(session, floors, result.bench.default_figures, folder.path() / "floor");
    }
    if (args.out.empty()) return;
    written = write_tables(result, plan, session, folder.path());
    folder.commit();
  });
  if (args.json) {
    fmt::print("{}\n", to_json(message_from_result(result, session), Defaults::kWritten));
    return;
  }
  if (!plan.knobs.empty()) fmt::print("{}\n", bench_table(result.bench));
  if (plan.with_peers) fmt::print("{}\n", peer_table(result.bench.peers));
  if (!result.floors.empty()) fmt::print("{}\n", floor_table(result.floors));
  if (!written.empty()) fmt::print("wrote {}: {}\n", args.out.string(), written);
}

}  // namespace

void add_bench(const Command& app, int* exit_code) {
  auto args = std::make_shared<BenchArguments>();
  const Command command = app.add_command(
      "bench", "Seconds of a fit against its error, for every knob, and that error's floor");
  command.add_option("session", args->session, "Session folder with its truth").required();
  command.add_option(
      "--out", args->out,
      "Folder for bench.json, bench.csv, peers.csv, floor.csv and bench.svg; --floor "
      "and --peers do without");
  command.add_option(
      "--knob", args->knobs,
      "This one alone [all of them; with --peers or --floor, none]; may be repeated");
  command.add_flag(
      "--peers", args->peers,
      "Peers alone, which a bench of everything has too: the paper in NumPy against the "
      "whole fit, SciPy's solvers against ours on the same profiles, where this "
      "machine's python3 has them");
  command.add_option(
      "--floor", args->floors,
      "The least that this error can be, FIGURE a column of bench.csv, or all: the same estimator "
      "with everything else from the session's truth. In the session's own photographs, and with "
      "normal deviates added to them that make the variance of the cameras' stated noise 2 and 4 "
      "times what it was; what error a law of squares through these leaves without noise is told. "
      "A floor of which noise makes less than half (of the square) is named as the model's error; "
      "a fit within 1.2 of any other has reached it. May be repeated");
  command.add_option(
      "--quieter", args->quieter,
      "Of --floor: session of the same subject with less noise (`lamella twin --noise 0`), "
      "measured too; may be repeated");
  command
      .add_option("--rounds", args->rounds,
                  "Fits of every setting, by turns; draws of the noise that --floor adds")
      .within(1, 100)
      .shows_default();
  command.add_flag("--json", args->json, "Report as JSON: bench.json");
  command.runs([args, exit_code] {
    run_bench_command(*args);
    *exit_code = 0;
  });
}

}  // namespace lamella::apps
