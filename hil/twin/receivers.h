// What a camera's pixels see of a subject, and how it is there.
#pragma once

#include <vector>

#include "base/camera.h"
#include "twin/diffusion.h"
#include "twin/subject.h"
#include "twin/surface.h"

namespace lamella::twin {

// One entry per pixel whose centre meets the subject.
struct Receivers {
  int width = 0, height = 0;
  std::vector<int> pixel;       // y * width + x
  std::vector<Vec3> to_camera;  // unit
  std::vector<Vec3> normal, shading_normal;
  std::vector<float> grid_row, grid_column;  // place on the surface's grid
  std::vector<Vec3> modulation;              // of depolarized light
  std::vector<float> intensity;              // c of eq. 1
  std::vector<uint8_t> label;                // 0: skin that truth leaves out
  ScatterTargets targets;                    // position, regions

  size_t size() const { return pixel.size(); }

  // Values per entry as an image; `background` elsewhere.
  Image3 image(const std::vector<Vec3>& values, const Vec3& background) const;
};

Receivers see_subject(const Camera& camera, const Surface& surface, const Subject& subject,
                      const std::array<Skin, kRegionCount>& skins);

}  // namespace lamella::twin
