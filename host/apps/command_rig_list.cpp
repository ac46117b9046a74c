// lamella rig list: the rigs that announce themselves on this network.
#include <fmt/format.h>

#include <memory>

#include "apps/commands.h"
#include "apps/process_child.h"
#include "apps/report.h"
#include "base/error.h"
#include "io/discovery.h"
#include "io/known_rigs.h"

namespace lamella::apps {

namespace {

constexpr double kListen_s = 3;

// Only what a rig says of itself, so "paired" is proven by TLS alone, once one talks to it.
bool looks_paired(const KnownRigs& known, const FoundRig& found) {
  for (const KnownRig& rig : known.rigs()) {
    const std::string prefix = to_hex(rig.fingerprint).substr(0, 16);
    if (prefix == found.fingerprint) return true;
  }
  return false;
}

int run_list(double wait_s, bool json) {
  catch_interrupts();
  const KnownRigs known(config_folder());
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const FoundRig& rig : find_rigs(wait_s, interrupted)) {
    list.push_back({{"name", rig.name},
                    {"rig", rig.address},
                    {"protocol_version", rig.version},
                    {"fingerprint_prefix", rig.fingerprint},
                    {"paired", looks_paired(known, rig)}});
    if (!json) {
      fmt::print("{:<24} {:<22} {}\n", rig.name, rig.address,
                 looks_paired(known, rig) ? "paired" : "not paired");
    }
  }
  if (json) print_json({{"rigs", list}});
  if (!json && list.empty()) fmt::print("no rig announces itself here\n");
  return 0;
}

}  // namespace

void add_rig_list(const Command& rig, int* exit_code) {
  auto wait_s = std::make_shared<double>(kListen_s);
  auto json = std::make_shared<bool>(false);
  const Command command = rig.add_command("list", "Rigs that announce themselves on this network");
  command.add_option("--wait", *wait_s, "Seconds to listen").within(0.1, 60.0).shows_default();
  command.add_flag("--json", *json, "Report as JSON");
  command.runs([=] { *exit_code = run_list(*wait_s, *json); });
}

std::string the_paired_rig() {
  const KnownRigs known(config_folder());
  std::vector<std::string> paired;
  for (const FoundRig& rig : find_rigs(kListen_s, interrupted)) {
    if (looks_paired(known, rig)) paired.push_back(rig.address);
  }
  if (paired.size() == 1) return paired[0];
  throw Error(Fault::kRig, "--rig",
              paired.empty() ? "no paired rig announces itself here"
                             : "several paired rigs announce themselves here",
              "give HOST:PORT; lamella rig list shows what there is");
}

}  // namespace lamella::apps
