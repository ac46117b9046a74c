// lamella capture: a burst taken by a rig, real or simulated, as a session on this disk.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/burst_fetch.h"
#include "apps/commands.h"
#include "apps/compare_statistics.h"
#include "apps/process_killed.h"
#include "apps/process_rig.h"
#include "apps/report.h"
#include "apps/rig_option.h"
#include "base/error.h"
#include "base/progress.h"
#include "calib/receive.h"
#include "io/json.h"
#include "io/layer_maps.h"
#include "io/paired_link.h"
#include "io/store_folder.h"
#include "io/whole_file.h"
#include "twin/rig.h"

namespace lamella::apps {

namespace {

constexpr double kSimulatedMargin_s = 900;  // the twin computes every photograph while we wait

struct Options {
  std::string rig = "sim";
  fs::path out;
  SimulatedRigOptions simulated;
  bool has_subject = false;
  bool held = false;
  bool discard_held = false;
  bool flashing_confirmed = false;
  bool replace = false;
  bool json = false;
};

struct Summary {
  double planned_s = 0;  // of a burst that was held, not known
  double actual_s = 0;
  double largest_edge_error_us = 0;
  double megabytes = 0;
  double megabytes_per_s = 0;
};

Summary summarise(const Burst& burst, const Reception& reception) {
  Summary s;
  s.planned_s = burst.planned_us * 1e-6;
  double first_us = 0, last_us = 0;
  for (const v1::TimedEdge& edge : reception.timing.edges()) {
    first_us = std::min(first_us, edge.actual_us());
    last_us = std::max(last_us, edge.actual_us());
  }
  s.actual_s = (last_us - first_us) * 1e-6;
  // Of every edge, as the rig counts those that were late and names the first in its verdict.
  s.largest_edge_error_us = largest_edge_error_us(reception.timing, Replaced::kToo);
  s.megabytes = double(reception.raw_bytes) * 1e-6;
  s.megabytes_per_s = s.megabytes / std::max(reception.transfer_s, 1e-9);
  return s;
}

void print_report(const Options& options, const Burst& burst, const Reception& reception) {
  const Summary s = summarise(burst, reception);
  const nlohmann::ordered_json report = {
      {"session", options.out.string()},
      {"frames", reception.offers.size()},
      {"raw_bytes", reception.raw_bytes},
      {"burst_planned_s", s.planned_s > 0 ? number(s.planned_s) : Json()},
      {"burst_actual_s", s.actual_s},
      {"edges", reception.timing.edges_size()},
      {"largest_edge_error_us", s.largest_edge_error_us},
      {"late_edges", burst.late_edges},
      {"marked", reception.marked},
      {"shortfall", burst.shortfall},
      {"unfit", reception.unfit},
      {"warnings", reception.warnings},
      {"retaken", reception.retaken},
      {"verdict", burst.verdict},
      {"transfer_s", reception.transfer_s},
      {"megabytes_per_s", s.megabytes_per_s}};
  print_json(report);
}

void print_table(const Options& options, const Burst& burst, const Reception& reception) {
  const Summary s = summarise(burst, reception);
  fmt::print("captured {}\n", one_line(options.out.string()));
  fmt::print("  photographs  {}, {:.1f} MB raw\n", reception.offers.size(), s.megabytes);
  const std::string planned = s.planned_s > 0 ? fmt::format("{:.3f} s planned, ", s.planned_s) : "";
  fmt::print("  burst        {}{:.3f} s played\n", planned, s.actual_s);
  fmt::print("  edges        {}, largest error {:.1f} us, {} late\n", reception.timing.edges_size(),
             s.largest_edge_error_us, burst.late_edges);
  fmt::print("  received and developed in {:.2f} s, {:.0f} MB/s\n", reception.transfer_s,
             s.megabytes_per_s);
  if (!reception.retaken.empty()) {
    fmt::print("  retaken      {} photographs within the burst; the first ones are in {}\n",
               reception.retaken.size(), one_line((options.out / "frames" / "retaken").string()));
  }
  for (const std::string& frame : reception.marked) {
    fmt::print("  to be retaken: {}\n", one_line(frame));
  }
  if (!burst.verdict.empty()) fmt::print("  verdict      {}\n", one_line(burst.verdict));
  if (!burst.shortfall.empty() && burst.shortfall != burst.verdict) {
    fmt::print("  partial      {}\n", one_line(burst.shortfall));
  }
  if (!reception.unfit.empty()) fmt::print("  not to fit   {}\n", one_line(reception.unfit));
}

// What the twin knows becomes the session's regions.png; the maps already lie in truth/.
void add_regions_of_truth(const fs::path& folder, v1::Session* manifest) {
  const fs::path labels = folder / "truth" / "regions.png";
  if (!fs::exists(labels)) return;
  manifest->mutable_regions()->set_file("regions.png");
  manifest->mutable_regions()->add_names("background");
  const v1::Layers layers = read_layers(folder / "truth" / "layers.json");
  for (const v1::Region& region : layers.regions()) {
    manifest->mutable_regions()->add_names(region.name());
  }
  write_json(folder / "session.json", *manifest);
  fs::copy_file(labels, folder / "regions.png");
}

std::string fault_of_subject(const std::string& name) {
  constexpr size_t kMostBytes = 63;  // PROTOCOL.md, BurstRequest
  if (printable(name) != name) return "is no UTF-8";
  return name.size() <= kMostBytes ? "" : fmt::format("at most {} bytes", kMostBytes);
}

// A rig of metal obeys none of these.
void require_for_simulated_rig(const Command& capture) {
  for (const char* option : {"--seed", "--scale", "--clock", "--rig-file"}) {
    if (capture.given(option)) {
      throw_bad_input(option, "is for the simulated rig alone", "give --rig sim with it");
    }
  }
}

LinkOptions link_options(const Options& options) {
  LinkOptions link;
  link.interrupted = interrupted;
  if (options.rig == "sim") {
    link.burst_margin_s = kSimulatedMargin_s;
    link.outlives_us = false;
  } else {
    link.tls = tls_for(options.rig, config_folder());
  }
  return link;
}

// What fails here once a rig of metal has its burst: the subject need not sit for it again.
template <class Work>
void while_rig_holds_burst(const std::string& rig, const Work& work) {
  try {
    work();
  } catch (const Error& e) {
    if (rig == "sim" || e.fault() != Fault::kBadInput) throw;
    throw Error(e.fault(), "", e.what(),
                "the burst is still on the rig: lamella rig sync --rig " + rig +
                    " --out FOLDER fetches it");
  }
}

// For a rig sync that comes after a capture whose link broke before the rig had let go of it all.
void note_burst(LinkClient* rig, const Burst& burst, const Reception& reception,
                const fs::path& session) {
  for (const v1::HeldBurst& held : rig->held()) {
    if (held.burst_id() == burst.id) write_burst_note(session, *rig, held, reception.offers);
  }
}

// The session is in its place, whatever becomes of the link.
void let_rig_forget(LinkClient* rig, const Options& options, const Reception& reception) {
  size_t forgotten = 0;
  const size_t all = reception.offers.size();
  try {
    for (; forgotten < all; ++forgotten) rig->acknowledge(reception.offers[forgotten]);
  } catch (const Error& e) {
    const std::string what = interrupted() ? rig->name() + ": interrupted" : e.what();
    const std::string whole = "the session is whole in " + options.out.string();
    if (options.rig == "sim") throw Error(e.fault(), "", what, whole);
    const fs::path folder = fs::absolute(options.out / "").parent_path().parent_path();
    const bool is_relative = options.out.is_relative();
    throw Error(e.fault(), "", what,
                whole + fmt::format("; the rig may still hold {} of its {} photographs: once it is "
                                    "back, lamella rig sync --rig {} --out {} lets it forget them",
                                    all - forgotten, all, options.rig,
                                    (is_relative ? fs::proximate(folder) : folder).string()));
  }
}

// Everything between a rig that answers and a session in its place.
int capture_from(const std::string& address, const Options& options, WholeFolder* folder) {
  LinkClient rig(address, link_options(options));
  // Nobody sits before the simulated rig.
  const bool confirmed = options.flashing_confirmed || options.rig == "sim";
  const bool named = options.has_subject || options.rig == "sim";
  const std::string subject = named ? options.simulated.subject : "";
  Burst burst =
      options.held ? rig.held_burst() : rig.run_burst(subject, options.discard_held, confirmed);
  if (named) burst.subject = subject;
  Reception reception;
  while_rig_holds_burst(options.rig, [&] {
    Progress progress("photographs", int(burst.frame_count));
    reception = receive_session(&rig, burst, *folder, [&](int n) { progress.advance(n); });
    add_regions_of_truth(folder->path(), &reception.manifest);
    if (options.rig != "sim") note_burst(&rig, burst, reception, folder->path());
    folder->commit();
    sync_to_disk(options.out);
  });
  for (const std::string& warning : reception.warnings) {
    fmt::print(stderr, "lamella: warning: {}\n", one_line(warning));
  }
  const auto report = options.json ? print_report : print_table;
  try {
    let_rig_forget(&rig, options, reception);
  } catch (const Error&) {
    report(options, burst, reception);
    throw;
  }
  report(options, burst, reception);
  return burst.shortfall.empty() && reception.marked.empty() ? 0 : 1;
}

int capture_simulated(Options options, WholeFolder* folder) {
  options.simulated.truth = fs::absolute(folder->path() / "truth");
  SimulatedRig rig(options.simulated);
  try {
    return capture_from(rig.address(), options, folder);
  } catch (const Error& e) {
    const std::string words = rig.last_words();
    if (words.empty() || e.fault() != Fault::kRig || interrupted()) throw;
    throw Error(Fault::kRig, "", std::string(e.what()) + " (" + words + ")");
  }
}

int capture(const Options& options) {
  require_outside_stores(options.out);
  if (!options.replace && fs::exists(options.out / "session.json")) {
    throw_bad_input(options.out.string(), "holds a session already",
                    "give another --out, or --replace to lose that one, its fit included");
  }
  if (options.rig == "sim") require_simulated_rig(options.simulated);
  catch_interrupts();
  clear_half_written_beside(options.out);
  WholeFolder folder(options.out, "session.json");
  int exit_code = 0;
  folder.blame_place([&] {
    exit_code = options.rig == "sim" ? capture_simulated(options, &folder)
                                     : capture_from(options.rig, options, &folder);
  });
  return exit_code;
}

}  // namespace

void add_capture(const Command& app, int* exit_code) {
  const Command command = app.add_command("capture", "Run a burst on a rig and receive it");
  auto options = std::make_shared<Options>();
  SimulatedRigOptions* simulated = &options->simulated;
  command.add_option("--rig", options->rig, "sim, or HOST:PORT of a rig")
      .check(rig_address(Simulated::kToo))
      .shows_default();
  command.add_option("--out", options->out, "Folder of the new session").required();
  command
      .add_option("--subject", simulated->subject,
                  "Name, in the session; for sim: head, where none is given, or sphere")
      .check(fault_of_subject);
  command.add_option("--seed", simulated->seed, "Of the simulated noise and skin")
      .check(fault_of_whole_number)
      .shows_default();
  command
      .add_option("--scale", simulated->scale,
                  fmt::format("Of the simulated photographs' size, {:g} to {:g}", twin::kLeastScale,
                              twin::kLargestScale))
      .shows_default();
  command.add_option("--clock", simulated->clock, "Of the simulated rig")
      .one_of({"virtual", "real"})
      .shows_default();
  command
      .add_option("--rig-file", simulated->rig_file,
                  "Wiring and timing of the simulated rig: a file, or one of " + shipped_rigs())
      .shows_default();
  command.add_flag("--held", options->held, "Fetch what the rig still holds; no new burst");
  command.add_flag("--discard-held", options->discard_held,
                   "Give up photographs of an earlier burst that the rig still holds");
  command.add_flag("--flashing-confirmed", options->flashing_confirmed,
                   "This subject was asked, and knows of no seizure that flashing light brings on");
  command.add_flag("--replace", options->replace,
                   "Put the new session where an old one is; the old one is lost");
  command.add_flag("--json", options->json, "Report as JSON");
  command.runs([command, options, exit_code] {
    if (options->rig != "sim") require_for_simulated_rig(command);
    options->has_subject = command.given("--subject");
    if (options->held && options->discard_held) {
      throw_bad_input("--discard-held", "gives up what --held fetches", "give one of them");
    }
    *exit_code = capture(*options);
  });
}

}  // namespace lamella::apps
