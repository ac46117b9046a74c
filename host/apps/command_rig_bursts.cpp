// lamella rig sync: every burst that a rig holds becomes a session here, and only then leaves the
// rig. lamella rig recover: what became of bursts that are not whole, and what is to be had of
// them.
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <functional>
#include <memory>

#include "apps/burst_fetch.h"
#include "apps/commands.h"
#include "apps/process_child.h"
#include "apps/process_interrupt.h"
#include "apps/process_killed.h"
#include "apps/recalibrated_source.h"
#include "apps/report.h"
#include "apps/resumed_source.h"
#include "apps/rig_option.h"
#include "base/error.h"
#include "io/paired_link.h"
#include "io/store_folder.h"

namespace lamella::apps {

namespace {

struct BurstArguments {
  std::string rig;
  fs::path store, out, calibration;
  bool json = false;
};

LinkOptions link_options(const std::string& address) {
  LinkOptions options;
  options.interrupted = interrupted;
  options.tls = tls_for(address, config_folder());
  return options;
}

std::string begun(const v1::HeldBurst& burst) {
  if (burst.begun_unix_us() <= 0) return "";
  const std::time_t seconds = std::time_t(burst.begun_unix_us() / 1000000);
  std::tm utc{};
  char text[32];
  if (!gmtime_r(&seconds, &utc) || !std::strftime(text, sizeof text, "%F %T UTC", &utc)) return "";
  return text;
}

nlohmann::ordered_json burst_json(const v1::HeldBurst& burst) {
  return {{"burst", burst.burst_id()},
          {"begun", begun(burst)},
          {"whole", burst.whole()},
          {"why", printable(burst.why())},
          {"flashing_confirmed", burst.flashing_confirmed()},
          {"photographs_held", burst.frames_held()},
          {"photographs_acknowledged", burst.frames_acknowledged()},
          {"photographs_expected", burst.frames_expected()},
          {"bytes_held", burst.bytes_held()}};
}

void print_burst(const v1::HeldBurst& burst) {
  const std::string at = begun(burst);
  fmt::print("burst {}{}: {}\n", burst.burst_id(), at.empty() ? "" : ", begun " + at,
             burst.whole() ? "whole" : "partial");
  fmt::print("  photographs  {} held, {:.1f} MB{}\n", burst.frames_held(),
             double(burst.bytes_held()) * 1e-6,
             burst.frames_acknowledged() > 0
                 ? fmt::format("; on a host already: {}", burst.frames_acknowledged())
                 : "");
  if (!burst.why().empty()) fmt::print("  why          {}\n", one_line(burst.why()));
}

void print_fetched(const FetchedBurst& fetched) {
  print_burst(fetched.held);
  if (!fetched.failed.empty()) {
    fmt::print("  NOT FETCHED  {}\n", one_line(fetched.failed));
  } else if (fetched.folder.empty()) {
    fmt::print("  fetched      nothing of it is whole\n");
  } else {
    fmt::print("  {}      {}\n", fetched.was_there ? "was in " : "fetched",
               fetched.folder.string());
  }
  if (!fetched.unfit.empty()) fmt::print("  not to fit   {}\n", one_line(fetched.unfit));
}

nlohmann::ordered_json fetched_json(const FetchedBurst& fetched) {
  nlohmann::ordered_json json = burst_json(fetched.held);
  json["session"] = printable(fetched.folder.string());
  json["was_there"] = fetched.was_there;
  json["marked"] = fetched.marked;
  json["warnings"] = nlohmann::ordered_json::array();
  for (const std::string& warning : fetched.warnings)
    json["warnings"].push_back(printable(warning));
  json["unfit"] = printable(fetched.unfit);
  json["failed"] = printable(fetched.failed);
  return json;
}

// Below the quality asked: a burst that is not whole, or has frames to be retaken. Failed: one that
// the rig could not give.
int judge(const FetchedBurst& fetched) {
  if (!fetched.failed.empty()) return 3;
  return fetched.held.whole() && !fetched.marked ? 0 : 1;
}

// Only a burst that is on this disk, or has nothing more to give, leaves the rig.
void forget_on_rig(LinkClient* rig, const FetchedBurst& fetched) {
  if (!fetched.failed.empty()) return;
  try {
    for (const v1::FrameOffer& offer : fetched.offers) rig->acknowledge(offer);
    if (fetched.offers.empty()) rig->release(fetched.held.burst_id());
  } catch (const Error& e) {
    if (interrupted()) throw;
    throw Error(e.fault(), "", e.what(),
                "what was fetched is here: sync again once the rig is back");
  }
}

void complain(const FetchedBurst& fetched) {
  for (const std::string& warning : fetched.warnings) {
    fmt::print(stderr, "lamella: warning: {}\n", one_line(warning));
  }
  if (fetched.failed.empty()) return;
  fmt::print(stderr, "lamella: burst {} was not fetched and stays where it is: {}\n",
             fetched.held.burst_id(), one_line(fetched.failed));
}

// What was done before a failure is told too: its sessions are here, and a rig has forgotten them.
void tend_to_each(BurstSource* source, const std::function<void(const v1::HeldBurst&)>& tend,
                  const nlohmann::ordered_json& tended, const std::function<void()>& report) {
  try {
    for (const v1::HeldBurst& held : source->held()) tend(held);
  } catch (...) {
    if (!tended.empty()) report();
    throw;
  }
  report();
}

void begin_in(const fs::path& out) {
  require_folder_place(out);
  require_outside_stores(out);
  clear_half_written_in(out);
}

int run_sync(const BurstArguments& args) {
  catch_interrupts();
  begin_in(args.out);
  LinkClient rig(args.rig, link_options(args.rig));
  ResumedSource source(&rig, args.out / ".fetching");
  nlohmann::ordered_json bursts = nlohmann::ordered_json::array();
  int exit_code = 0;
  const auto fetch = [&](const v1::HeldBurst& held) {
    const FetchedBurst fetched = try_to_fetch(&source, held, args.out);
    complain(fetched);
    exit_code = std::max(exit_code, judge(fetched));
    bursts.push_back(fetched_json(fetched));
    if (!args.json) print_fetched(fetched);
    forget_on_rig(&rig, fetched);
    source.forget(fetched.offers);
  };
  tend_to_each(&rig, fetch, bursts, [&] {
    if (args.json) print_json({{"rig", args.rig}, {"bursts", bursts}});
    if (!args.json && bursts.empty()) fmt::print("{} holds no bursts\n", args.rig);
  });
  return exit_code;
}

std::unique_ptr<BurstSource> source_of(const BurstArguments& args) {
  if (args.rig.empty() == args.store.empty()) {
    throw_bad_input("rig recover", "needs either --store or --rig",
                    "give the folder from a rig's disk, or the rig's HOST:PORT");
  }
  if (!args.store.empty()) return std::make_unique<StoreFolder>(args.store);
  LinkOptions options = link_options(args.rig);
  options.once_interrupted = "nothing was changed there; recover again to see the rest";
  return std::make_unique<LinkClient>(args.rig, options);
}

// With the calibration that is given, in place of each burst's own; nullptr where none is.
std::unique_ptr<RecalibratedSource> recalibrated(const BurstArguments& args) {
  if (args.calibration.empty()) return nullptr;
  if (args.out.empty()) {
    throw_bad_input("rig recover --calibration", "nothing is fetched without --out",
                    "give the folder for the sessions");
  }
  return std::make_unique<RecalibratedSource>(source_of(args), args.calibration);
}

// A store without its counter is one too, where it is the one that is read.
void require_outside_store_read(const BurstArguments& args) {
  if (!args.store.empty() && lies_in(args.out, args.store)) {
    throw_bad_input(args.out.string(), "is in the store that is read",
                    "name a folder outside " + args.store.string());
  }
}

// Exit 1 where a burst is not whole, 3 where one could not be fetched.
int run_recover(const BurstArguments& args) {
  if (args.store.empty()) {
    catch_interrupts();
  } else {
    abandon_outputs_on_interrupt();  // a disk does not keep anybody waiting
  }
  const std::unique_ptr<RecalibratedSource> other = recalibrated(args);
  const std::unique_ptr<BurstSource> own = other ? nullptr : source_of(args);
  BurstSource* source = other ? other.get() : own.get();
  if (!args.out.empty()) {
    require_outside_store_read(args);
    begin_in(args.out);
  }
  nlohmann::ordered_json bursts = nlohmann::ordered_json::array();
  int partial = 0, whole = 0, exit_code = 0;
  const auto explain = [&](const v1::HeldBurst& held) {
    FetchedBurst fetched;
    fetched.held = held;
    if (!args.out.empty()) fetched = try_to_fetch(source, held, args.out);
    if (other && fetched.was_there) other->require_same_in(fetched.folder);
    complain(fetched);
    exit_code = std::max(exit_code, fetched.failed.empty() ? (held.whole() ? 0 : 1) : 3);
    ++(held.whole() ? whole : partial);
    bursts.push_back(args.out.empty() ? burst_json(held) : fetched_json(fetched));
    if (args.json) return;
    if (args.out.empty()) {
      print_burst(held);
    } else {
      print_fetched(fetched);
    }
  };
  const std::string where = printable(args.rig.empty() ? args.store.string() : args.rig);
  tend_to_each(source, explain, bursts, [&] {
    if (args.json) {
      print_json({{"source", where}, {"whole", whole}, {"partial", partial}, {"bursts", bursts}});
    } else {
      fmt::print("{}: {} whole, {} partial; nothing was changed there\n", where, whole, partial);
    }
  });
  return exit_code;
}

}  // namespace

void add_rig_bursts(const Command& rig, int* exit_code) {
  auto args = std::make_shared<BurstArguments>();
  const Command sync =
      rig.add_command("sync", "Fetch every burst that a rig holds, which then lets it go");
  sync.add_option("--rig", args->rig, "HOST:PORT of the rig")
      .check(rig_address(Simulated::kNot))
      .required();
  sync.add_option("--out", args->out, "Folder for the sessions, burst-NUMBER each").required();
  sync.add_flag("--json", args->json, "Report as JSON");
  sync.runs([args, exit_code] { *exit_code = run_sync(*args); });
  const Command recover =
      rig.add_command("recover", "What became of bursts that were cut off, and what is whole");
  recover.add_option("--store", args->store, "Folder from a rig's disk, taken out of it");
  recover.add_option("--rig", args->rig, "HOST:PORT of the rig")
      .check(rig_address(Simulated::kNot));
  recover.add_option("--out", args->out, "Also put what is whole into sessions in this folder");
  recover.add_option("--calibration", args->calibration,
                     "Give the sessions this calibration.json, not their burst's own");
  recover.add_flag("--json", args->json, "Report as JSON");
  recover.runs([args, exit_code] { *exit_code = run_recover(*args); });
}

}  // namespace lamella::apps
