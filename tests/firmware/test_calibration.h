// A calibration of a rig of firmware/board, with no more than a daemon asks for.
#pragma once

#include <string>

// Line 3: the LEDs; 5 and 6: the cameras; 7: the projector; 8: the patterns.
std::string calibration_text(int width = 160, int height = 120, const std::string& subject = "",
                             const std::string& rig = "sim");
