// A simulated rig in memory, before a fake twin, with faults that its firmware is not told of.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "fake_twin.h"
#include "test_rig.h"

extern "C" {
#include "hal_sim.h"
#include "store.h"
}

struct FaultyRig {
  // As --inject takes them.
  explicit FaultyRig(const std::vector<std::string>& injected) : block(4 << 20) {
    sim_faults faults = kSimNoFaults;
    for (const std::string& fault : injected) {
      EXPECT_TRUE(sim_faults_parse(fault.c_str(), &faults)) << fault;
    }
    EXPECT_EQ(hal_sim_open(&sim, &rig, SIM_CLOCK_VIRTUAL, faults, twin.path().c_str()), LAM_OK);
    store_init(&photographs, block.data(), block.size());
  }
  ~FaultyRig() { sim.hal.close(&sim); }
  FaultyRig(const FaultyRig&) = delete;
  FaultyRig& operator=(const FaultyRig&) = delete;

  struct rig rig = test_rig();
  FakeTwin twin;
  std::vector<uint8_t> block;
  struct hal_sim sim;
  struct store photographs;
};
