// The rig that the twin stands in for: 150 LEDs, two cameras beside a projector, and its patterns.
#pragma once

#include "io/session.h"

namespace lamella::twin {

inline constexpr int kLedCount = 150;

// Of the photographs' size: smaller ones show no skin, larger ones do not fit in memory.
inline constexpr double kLeastScale = 0.1, kLargestScale = 4;

// Throws Error where `scale` is not within them.
void require_scale(double scale);

// Directions in the order that PROTOCOL.md fixes: a frequency-4 icosahedral sphere without the
// stand and the opening for the cameras, by height falling, then azimuth rising.
std::vector<Vec3> led_directions();

// A session without frames: the rig with everything calibrated. `scale` multiplies the cameras'
// resolution (600 x 750 at 1), `noise` their noise (0: quantisation alone), as the manifest will
// state it.
Session make_rig(const std::string& subject, double scale, double noise = 1);

}  // namespace lamella::twin
