// From light to raw sensor values: photon and read noise, 12 bits, clipping.
#pragma once

#include <cstdint>

#include "base/camera.h"
#include "base/vec.h"
#include "io/raw12.h"

namespace lamella::twin {

inline constexpr int kBlackLevelDn = 64, kWhiteLevelDn = 4095;

// stored = (dn - black level) * this; the white level is the camera's saturation.
double gain_per_dn(const Camera& camera);

// `stored`: exact values in stored units. The noise is what the camera's figures state: no photon
// noise where full_well_electrons is 0. The same seed gives the same noise.
RawImage expose(const Image3& stored, const Camera& camera, uint64_t seed);

Image3 develop(const RawImage& raw, const Camera& camera);

}  // namespace lamella::twin
