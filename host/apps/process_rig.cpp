#include "apps/process_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

#include "base/error.h"
#include "base/progress.h"
#include "twin/rig.h"
#include "twin/subject.h"

namespace lamella::apps {

namespace {

const Awaited kTwinServes{"serving ", 180, "working out how its skin scatters light"};
const Awaited kTwinPrepared{"prepared", 180, "working out what a burst will show"};
const Awaited kFirmwareListens{"listening on ", 20, "starting on its simulated hardware"};

// Of an installed program beside it, else of the source tree that it was built from.
fs::path board_folder() {
  const fs::path installed = own_binary().parent_path().parent_path() / "share/lamella/board";
  return fs::exists(installed) ? installed : fs::path(LAMELLA_BOARD_DIR);
}

std::string firmware_binary() { return (own_binary().parent_path() / "lamella-rigd").string(); }

[[noreturn]] void throw_bad_rig_file(const ChildProcess& firmware, const std::string& rig_file) {
  const std::string complaint = firmware.complaint();
  if (complaint.starts_with("lamella-rigd: ")) throw_bad_input("", complaint);  // of an argument
  throw_bad_input("--rig-file", complaint,
                  "lamella-rigd --check --rig " + rig_file + " names all that is wrong");
}

std::string await_ready(ChildProcess* child, const Awaited& awaited) {
  const Stopwatch watch;
  Progress progress("starting the simulated rig, seconds of at most", int(awaited.longest_s));
  return child->wait_for_line(awaited, [&] {
    progress.advance(int(watch.seconds()));
    return interrupted();
  });
}

}  // namespace

std::string find_rig_file(const fs::path& name) {
  if (fs::exists(name)) return name.string();
  const fs::path shipped = board_folder() / (name.string() + ".rig");
  const bool is_bare = !name.has_parent_path() && !name.has_extension();
  if (is_bare && fs::exists(shipped)) return shipped.string();
  throw_bad_input("--rig-file", "\"" + name.string() + "\": no such file",
                  "rigs that ship: " + shipped_rigs());
}

std::vector<fs::path> files_of_rig(const fs::path& rig_file) {
  std::vector<fs::path> files{rig_file};
  if (!fs::is_regular_file(rig_file)) return files;  // to be refused: a pipe would be waited for
  std::ifstream text(rig_file);
  for (std::string line; std::getline(text, line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string key, equals, value;
    if (!(words >> key >> equals) || key != "leds.file" || equals != "=") continue;
    std::getline(words >> std::ws, value);
    value.erase(value.find_last_not_of(" \t\r") + 1);
    files.push_back(rig_file.parent_path() / value);
  }
  return files;
}

std::string shipped_rigs() {
  std::vector<std::string> names;
  std::error_code failed;  // then there are none
  for (const fs::directory_entry& entry : fs::directory_iterator(board_folder(), failed)) {
    if (entry.path().extension() == ".rig") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return fmt::format("{}", fmt::join(names, ", "));
}

void require_simulated_rig(const SimulatedRigOptions& options) {
  twin::require_subject(options.subject);
  twin::require_scale(options.scale);
  const PrivateFolder folder;
  const std::string rig_file = find_rig_file(options.rig_file);
  std::vector<std::string> arguments{firmware_binary(), "--check", "--rig", rig_file};
  for (const std::string& fault : options.inject) {
    arguments.insert(arguments.end(), {"--inject", fault});
  }
  ChildProcess check("lamella-rigd", arguments, folder.path());
  if (check.wait() != 0) throw_bad_rig_file(check, rig_file);
}

v1::Plan plan_of_rig_file(const fs::path& rig_file) {
  const PrivateFolder folder;
  const std::string found = find_rig_file(rig_file);
  ChildProcess firmware("lamella-rigd", {firmware_binary(), "--plan", "--rig", found},
                        folder.path());
  if (firmware.wait() != 0) throw_bad_rig_file(firmware, found);
  v1::Plan plan;
  if (!plan.ParseFromString(firmware.output())) {
    throw Error(Fault::kRig, "lamella-rigd", "wrote no plan", "is it of this build?");
  }
  return plan;
}

SimulatedRig::SimulatedRig(const SimulatedRigOptions& options) {
  const std::string socket = (folder_.path() / "twin.socket").string();
  const std::string calibration = (folder_.path() / "calibration.json").string();
  // clang-format off
  std::vector<std::string> twin{
      own_binary().string(), "twin",
      "--serve", socket,
      "--subject", options.subject,
      "--seed", std::to_string(options.seed),
      "--scale", fmt::format("{}", options.scale),
      "--calibration-out", calibration};
  std::vector<std::string> firmware{
      firmware_binary(),
      "--hal", "sim",
      "--rig", find_rig_file(options.rig_file),
      "--twin", socket,
      "--calibration", calibration,
      "--listen", "127.0.0.1:0",
      "--clock", options.clock};
  // clang-format on
  if (!options.truth.empty()) twin.insert(twin.end(), {"--truth-out", options.truth.string()});
  if (!options.takes_bursts) twin.push_back("--no-burst");
  for (const std::string& fault : options.inject) {
    firmware.insert(firmware.end(), {"--inject", fault});
  }
  if (!options.led_reference.empty()) {
    firmware.insert(firmware.end(), {"--led-reference", options.led_reference.string()});
  }
  twin_ = std::make_unique<ChildProcess>("lamella twin", twin, folder_.path());
  // On the real clock nothing else may work while edges are played, the twin least of all.
  await_ready(twin_.get(), options.clock == "real" ? kTwinPrepared : kTwinServes);
  firmware_ = std::make_unique<ChildProcess>("lamella-rigd", firmware, folder_.path());
  address_ = await_ready(firmware_.get(), kFirmwareListens);
}

std::string SimulatedRig::last_words() {
  constexpr int kLooks = 100;  // one that fell silent may take a second to end
  for (int i = 0; i < kLooks; ++i) {
    for (ChildProcess* child : {twin_.get(), firmware_.get()}) {
      if (child->has_ended()) return child->last_words();
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return "";
}

}  // namespace lamella::apps
