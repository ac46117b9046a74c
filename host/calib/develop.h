// From what a sensor gave to what a session stores.
#pragma once

#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "io/raw12.h"

namespace lamella {

struct RawFormat {
  double black_level_dn = 0;  // raw value of no light
  double gain_per_dn = 1;     // stored units per raw step
  double saturation = 1e30;   // stored units; of the camera
  RawPixels pixels = RawPixels::kRgb;
};

// Stored values of a raw photograph, three colours a pixel (grey: three times the same; a mosaic:
// demosaic.h): (dn - black_level_dn) * gain_per_dn. Noise may take them
// below zero, and they stay there. A clipped value stays at or above `saturation` when it is
// rounded to half precision. An empty image: `bytes` has another length than `size` needs.
Image3 develop(const std::vector<uint8_t>& bytes, cv::Size size, const RawFormat& format);

}  // namespace lamella
