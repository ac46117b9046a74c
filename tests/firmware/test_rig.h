// The rig that every firmware test runs on: board/sim.rig as it ships.
#pragma once

#include <string>

extern "C" {
#include "rig.h"
}

// Text of board/NAME.rig.
std::string rig_file_text(const std::string& name = "sim");
struct rig test_rig();
