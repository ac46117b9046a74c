// From what a sensor gave to what a session stores.
#pragma once

#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace lamella {

struct RawFormat {
  double black_level_dn = 0;  // raw value of no light
  double gain_per_dn = 1;     // stored units per raw step
  double saturation = 1e30;   // stored units; of the camera
};

// Stored values of an "RGB12P" photograph: (dn - black_level_dn) * gain_per_dn. Noise may take them
// below zero, and they stay there. A clipped value stays at or above `saturation` when it is
// rounded to half precision. An empty image: `bytes` has another length than `size` needs.
Image3 develop(const std::vector<uint8_t>& bytes, cv::Size size, const RawFormat& format);

}  // namespace lamella
