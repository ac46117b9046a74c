#include "apps/process_rig.h"

#include <fmt/format.h>

#include <chrono>
#include <thread>

#include "base/error.h"
#include "base/progress.h"
#include "twin/rig.h"
#include "twin/subject.h"

namespace lamella::apps {

namespace {

constexpr double kTwinReady_s = 180;  // it simulates its skin first
constexpr double kFirmwareReady_s = 20;

fs::path rig_file_of(const SimulatedRigOptions& options) {
  return options.rig_file.empty() ? fs::path(LAMELLA_BOARD_DIR) / "sim.rig" : options.rig_file;
}

std::string firmware_binary() { return (own_binary().parent_path() / "lamella-rigd").string(); }

}  // namespace

void require_simulated_rig(const SimulatedRigOptions& options) {
  twin::require_subject(options.subject);
  twin::require_scale(options.scale);
  const PrivateFolder folder;
  const std::string rig_file = rig_file_of(options).string();
  ChildProcess check("lamella-rigd", {firmware_binary(), "--check", "--rig", rig_file},
                     folder.path());
  if (check.wait() != 0) throw_bad_input("--rig-file", check.last_words());
}

SimulatedRig::SimulatedRig(const SimulatedRigOptions& options) {
  const std::string socket = (folder_.path() / "twin.socket").string();
  const std::string calibration = (folder_.path() / "calibration.json").string();
  // clang-format off
  const std::vector<std::string> twin{
      own_binary().string(), "twin",
      "--serve", socket,
      "--subject", options.subject,
      "--seed", std::to_string(options.seed),
      "--scale", fmt::format("{}", options.scale),
      "--calibration-out", calibration,
      "--truth-out", options.truth.string()};
  const std::vector<std::string> firmware{
      firmware_binary(),
      "--hal", "sim",
      "--rig", rig_file_of(options).string(),
      "--twin", socket,
      "--calibration", calibration,
      "--listen", "127.0.0.1:0",
      "--clock", options.clock};
  // clang-format on
  Progress progress("starting the simulated rig", 2);
  twin_ = std::make_unique<ChildProcess>("lamella twin", twin, folder_.path());
  twin_->wait_for_line("serving ", kTwinReady_s, interrupted);
  progress.advance(1);
  firmware_ = std::make_unique<ChildProcess>("lamella-rigd", firmware, folder_.path());
  address_ = firmware_->wait_for_line("listening on ", kFirmwareReady_s, interrupted);
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
