// The rig that every firmware test runs on: board/sim.rig as it ships.
#pragma once

#include <string>

extern "C" {
#include "rig.h"
}

std::string rig_file_text();
struct rig test_rig();
