// What one exposure was lit by: the report of the simulated rig, checked and integrated over time.
// The contract of light is in proto/PROTOCOL.md.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "twin.pb.h"

namespace lamella::twin {

// A state of the rig's light that does not change: LED codes, or a pattern of the projector.
struct LightState {
  std::vector<uint16_t> codes;  // 0 to 4095, one per LED; empty: the projector
  v1::PatternSpan::Kind pattern = v1::PatternSpan::KIND_UNSPECIFIED;
  uint32_t index = 0;

  bool is_leds() const { return !codes.empty(); }
  bool operator==(const LightState&) const = default;
};

// How much of a state's S and D the sensor collected, in units of its reference time.
struct Contribution {
  LightState light;
  double polarized = 0, depolarized = 0;
};

struct Exposure {
  int camera = 0;  // 0 left, 1 right
  std::vector<Contribution> contributions;
};

// Integral over [a, b] of cos^2 of an angle that goes linearly from `from_rad` to `to_rad`.
double malus_integral(double a, double b, double from_rad, double to_rad);

// Throws Error that names the field: NaN times, light outside the exposure, codes of another count
// than `led_count` or over 4095, an unknown pattern, an analyser that does not cover the exposure.
Exposure read_exposure(const v1::ExposureReport& report, int led_count, int fringe_count);

}  // namespace lamella::twin
