// lamella-rigd on the simulated rig, with a twin of its own and a folder.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "fake_twin.h"
#include "test_calibration.h"
#include "test_host.h"

class Rigd : public ::testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/lamella-rigd-test-XXXXXX";
    folder = mkdtemp(name);
    std::ofstream(folder / "calibration.json") << calibration_text();
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  std::vector<std::string> arguments(const std::vector<std::string>& more = {}) {
    std::vector<std::string> all = {"--hal",         "sim",
                                    "--rig",         LAMELLA_BOARD_DIR "/sim.rig",
                                    "--calibration", folder / "calibration.json",
                                    "--listen",      "127.0.0.1:0"};
    const bool by_twin = std::find(more.begin(), more.end(), "--test-frames") == more.end();
    if (by_twin) all.insert(all.end(), {"--twin", twin.path()});
    all.insert(all.end(), more.begin(), more.end());
    return last_of_each(all);
  }

  std::filesystem::path folder;
  FakeTwin twin{300};  // photographs of some 200 kB: several chunks each
};
