// The rig that every firmware test runs on: board/sim.rig as it ships.
#pragma once

#include <string>
#include <vector>

extern "C" {
#include "burst.h"
#include "rig.h"
}

std::string board_text(const std::string& file_name);  // of firmware/board
inline std::string rig_file_text() { return board_text("sim.rig"); }

struct rig test_rig(const std::string& name = "sim");  // board/NAME.rig with its LEDs

// The paper's burst, in its cheapest order, from where the rig parks its analyser.
struct burst_plan planned(const struct rig& rig);
struct burst_plan planned(const struct rig& rig, const std::vector<burst_step>& steps,
                          bool starts_crossed);
