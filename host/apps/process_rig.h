// A rig without hardware: the digital twin and the firmware on its simulated hardware, started
// beside this program and ended with it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "apps/process_child.h"
#include "plan.pb.h"

namespace lamella::apps {

struct SimulatedRigOptions {
  std::string subject = "head";  // or "sphere"
  uint64_t seed = 1;
  double scale = 1;                 // of the photographs' size, twin::kLeastScale to kLargestScale
  std::string clock = "virtual";    // or "real"
  std::vector<std::string> inject;  // faults of the simulated hardware
  fs::path led_reference;           // where the firmware keeps what it learns of its LEDs
  fs::path rig_file = "sim";        // a file, or the name of a rig that ships
  fs::path truth;                   // where the twin writes what it knows; empty: nowhere
  bool takes_bursts = true;         // false: the twin works none out beforehand
};

// The names that a rig file may be given by: "pi4, pi5, ...".
std::string shipped_rigs();

// The rig file that `name` stands for: that of a bare name ships, unless there is such a file here.
// Throws Error (kBadInput) where there is none.
std::string find_rig_file(const fs::path& name);

// What is read of a rig: that file, and the list of LEDs that it names.
std::vector<fs::path> files_of_rig(const fs::path& rig_file);

// Throws Error (kBadInput) that names the option where the twin or the firmware would refuse it, so
// that nobody waits for the twin to hear of a mistyped name.
void require_simulated_rig(const SimulatedRigOptions& options);

// The burst that the firmware plans for a rig file. Throws Error (kBadInput) with the firmware's
// own line where the file is wrong.
v1::Plan plan_of_rig_file(const fs::path& rig_file);

class SimulatedRig {
 public:
  // Returns when both are ready. Throws Error (kRig).
  explicit SimulatedRig(const SimulatedRigOptions& options);

  const std::string& address() const { return address_; }  // HOST:PORT of the link

  // What it said last, where one of the two has ended before its time; else nothing.
  std::string last_words();

 private:
  PrivateFolder folder_;
  std::unique_ptr<ChildProcess> twin_;
  std::unique_ptr<ChildProcess> firmware_;
  std::string address_;
};

}  // namespace lamella::apps
