// What lamella-rigd says of a calibration.
#pragma once

#include <string>

namespace lamella::testing {

// "" where it is taken on firmware/board/sim.rig with the first `leds` of its LEDs.
std::string complaint_of_daemon(const std::string& calibration, size_t leds);

}  // namespace lamella::testing
