// Light that enters the skin, and how it spreads beneath before it leaves (sec. 4.2, eq. 5 to 8).
#pragma once

#include <cstdint>
#include <vector>

#include "render/exit_kernels.h"
#include "render/lights.h"
#include "render/surface.h"

namespace lamella::render {

// Which lights each vertex sees, a bit each.
class Visibility {
 public:
  Visibility(const Surface& surface, const Lights& lights);

  // 1 where vertex `v` sees light `i`, else 0.
  float operator()(size_t i, int v) const {
    return float(bits_[size_t(v) * words_ + i / 64] >> (i % 64) & 1);
  }

 private:
  size_t words_;
  std::vector<uint64_t> bits_;
};

// Radiance of a white Lambertian surface lying at each vertex: the light that enters there.
std::vector<Vec3> irradiance(const Surface& surface, const Lights& lights,
                             const Visibility& visibility);

// The irradiance that a point of the surface answers to: spread by the layer's kernel over its
// surroundings, normalised so that even light stays what it is.
struct SpreadLight {
  std::vector<Vec3> shallow, deep;  // by vertex
};

// By the kernels of each vertex's region. Where there is none, or where one is narrower than the
// spacing of the vertices, light leaves where it enters: such a kernel is albedo, not scattering.
SpreadLight spread(const RegionKernels& kernels, const Surface& surface,
                   const std::vector<Vec3>& irradiance);

}  // namespace lamella::render
