// lamella bench SESSION: what each knob of the fit costs and what it brings.
#include <fmt/format.h>

#include <memory>

#include "apps/bench_chart.h"
#include "apps/bench_run.h"
#include "apps/commands.h"
#include "apps/process_interrupt.h"
#include "apps/process_killed.h"
#include "apps/report.h"
#include "base/error.h"
#include "io/json.h"
#include "io/whole_file.h"

namespace lamella::apps {

namespace {

struct BenchArguments {
  fs::path session, out;
  std::vector<std::string> knobs;
  int rounds = 3;
  bool json = false;
};

std::vector<Knob> chosen_knobs(const std::vector<std::string>& names) {
  const std::vector<Knob> all = bench_knobs();
  if (names.empty()) return all;
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

void run_bench_command(const BenchArguments& args) {
  const std::vector<Knob> knobs = chosen_knobs(args.knobs);
  abandon_outputs_on_interrupt();
  const Session session = read_session(args.session);
  clear_half_written_beside(args.out);
  WholeFolder folder(args.out, "bench.json");
  Bench bench;
  folder.blame_place([&] {
    bench = run_bench(session, knobs, args.rounds, folder.path() / "fit");
    const std::string title = fmt::format("{}, {} x {} pixels", one_line(session.subject),
                                          session.left.width, session.left.height);
    write_whole_text(folder.path() / "bench.csv", bench_csv(bench));
    write_json(folder.path() / "bench.json", message_from_bench(bench, session),
               Defaults::kWritten);
    write_whole_text(folder.path() / "bench.svg", bench_chart(bench, knobs, title));
    folder.commit();
  });
  if (args.json) {
    fmt::print("{}\n", to_json(message_from_bench(bench, session), Defaults::kWritten));
  } else {
    fmt::print("{}\nwrote {}: bench.csv, bench.json, bench.svg\n", bench_table(bench),
               args.out.string());
  }
}

}  // namespace

void add_bench(const Command& app, int* exit_code) {
  auto args = std::make_shared<BenchArguments>();
  const Command command =
      app.add_command("bench", "Seconds of a fit against its error, for every knob");
  command.add_option("session", args->session, "Session folder with its truth").required();
  command.add_option("--out", args->out, "Folder for bench.csv, bench.json and bench.svg")
      .required();
  command.add_option("--knob", args->knobs, "This one alone [all of them]; may be repeated");
  command.add_option("--rounds", args->rounds, "Fits of every setting, by turns")
      .within(1, 100)
      .shows_default();
  command.add_flag("--json", args->json, "Report as JSON: bench.json");
  command.runs([args, exit_code] {
    run_bench_command(*args);
    *exit_code = 0;
  });
}

}  // namespace lamella::apps
