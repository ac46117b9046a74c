// lamella rig pair: a rig and this host come to trust each other while its button is held; or part.
#include <fmt/format.h>

#include <iostream>
#include <memory>

#include "apps/commands.h"
#include "apps/process_child.h"
#include "apps/report.h"
#include "apps/rig_option.h"
#include "base/error.h"
#include "base/progress.h"
#include "io/known_rigs.h"
#include "io/pairing.h"

namespace lamella::apps {

namespace {

struct PairArguments {
  std::string rig;
  double wait_s = 60;
  bool forget = false;
  bool json = false;
};

std::string read_code_from_operator() {
  fmt::print(stderr, "The rig blinks five digits, over and over. Type them: ");
  std::string line;
  if (std::getline(std::cin, line)) return line;
  fmt::print(stderr, "\n");
  throw_bad_input("code", "nothing was typed", "start again, and type what the rig blinks");
}

void report(const PairArguments& args, const KnownRig& rig, const std::string& what) {
  if (args.json) {
    print_json({{"rig", args.rig},
                {"name", rig.name},
                {"fingerprint", to_hex(rig.fingerprint)},
                {"state", what}});
  } else {
    fmt::print("{}: {} ({}, key {})\n", args.rig, what, one_line(rig.name),
               to_hex(rig.fingerprint).substr(0, 16));
  }
}

int run_pair(const PairArguments& args) {
  const fs::path folder = config_folder();
  KnownRigs known(folder);
  const auto identity = std::make_shared<const Identity>(folder);
  PairingOptions options;
  options.wait_s = args.wait_s;
  options.interrupted = interrupted;
  options.read_code = read_code_from_operator;
  options.reached = [] { fmt::print(stderr, "Hold START on the rig until its light blinks.\n"); };
  catch_interrupts();
  const KnownRig rig = pair_with_rig(args.rig, identity, options);
  known.add(rig);
  report(args, rig, "paired");
  return 0;
}

// Exit 1 where the rig could not be told.
int run_forget(const PairArguments& args) {
  const fs::path folder = config_folder();
  KnownRigs known(folder);
  const KnownRig* found = known.at(args.rig);
  if (!found)
    throw_bad_input("--rig", args.rig + " is not paired with this host",
                    "`lamella rig pair --rig HOST:PORT` pairs them");
  const KnownRig rig = *found;
  std::string failure;
  try {
    const auto identity = std::make_shared<const Identity>(folder);
    be_forgotten(args.rig, identity, rig.fingerprint, {});
  } catch (const Error& e) {
    if (e.fault() != Fault::kRig) throw;
    failure = e.what();
  }
  known.forget(args.rig);
  report(args, rig, failure.empty() ? "forgotten" : "forgotten here alone");
  if (failure.empty()) return 0;
  fmt::print(stderr, "lamella: warning: the rig still lets this host in: {}\n", one_line(failure));
  return 1;
}

}  // namespace

void add_rig_pair(const Command& rig, int* exit_code) {
  auto args = std::make_shared<PairArguments>();
  const Command command =
      rig.add_command("pair", "Make a rig and this host trust each other, START being held");
  command.add_option("--rig", args->rig, "HOST:PORT of the rig")
      .check(rig_address(Simulated::kNot))
      .required();
  command.add_option("--wait", args->wait_s, "Seconds to wait for the button, at most 60")
      .within(0.0, 60.0)
      .shows_default();
  command.add_flag("--forget", args->forget, "Undo it, at both ends");
  command.add_flag("--json", args->json, "Report as JSON");
  command.runs(
      [args, exit_code] { *exit_code = args->forget ? run_forget(*args) : run_pair(*args); });
}

}  // namespace lamella::apps
