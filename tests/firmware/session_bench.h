// A session on the simulated rig before a fake twin.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "fake_twin.h"
#include "test_rig.h"

extern "C" {
#include "hal_sim.h"
#include "session.h"
#include "store.h"
}

// A rig in memory before a fake twin.
struct Bench {
  explicit Bench(sim_faults faults = kSimNoFaults, FakeTwin::Mood mood = FakeTwin::Mood::kHonest,
                 sim_clock clock = SIM_CLOCK_VIRTUAL)
      : twin(1, mood), block(4 << 20) {
    EXPECT_EQ(hal_sim_open(&sim, &rig, clock, faults, twin.path().c_str()), LAM_OK)
        << sim.hal.error;
    store_init(&photographs, block.data(), block.size());
    session_init(&session, &rig, &sim.hal, &photographs);
  }
  ~Bench() {
    session_close(&session);
    sim.hal.close(&sim);
  }

  // Runs a burst to its end.
  const lamella_v1_BurstDone& burst() {
    EXPECT_EQ(session_request_burst(&session, true), LAM_OK) << session.refusal;
    while (session_work(&session)) continue;
    return session.done;
  }

  // The photograph of a role with the left camera.
  std::vector<double> picture(lamella_v1_Frame_Role role, bool crossed) {
    for (size_t i = 0; i < photographs.count; i++) {
      const struct photograph& p = photographs.photographs[i];
      const bool is_crossed = p.frame.analyser == lamella_v1_Frame_Analyser_CROSS;
      if (p.frame.role == role && is_crossed == crossed && p.frame_id % 2 == 0) {
        return unpack_first_row(p.bytes);
      }
    }
    ADD_FAILURE() << "no photograph of role " << role;
    return std::vector<double>(kFakePixels);
  }

  struct rig rig = test_rig();
  FakeTwin twin;
  std::vector<uint8_t> block;
  struct hal_sim sim;
  struct store photographs;
  struct session session;
};
