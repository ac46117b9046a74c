// Which lights the subject hides from which parts of itself, on a coarse grid of nodes: every LED,
// and the projector.
#pragma once

#include <cstdint>
#include <vector>

#include "base/camera.h"
#include "base/light_stage.h"
#include "base/vec.h"

namespace lamella::fit {

// Everything that the left camera saw casts shadows; what it did not see casts none. Shadows of the
// sphere's lights are wide compared with a node's spacing, so between nodes they are interpolated.
class LightVisibility {
 public:
  static constexpr int kLeastStep_px = 8;

  // Pixels between nodes that are fine enough for a face, seen by `camera`.
  static int step_for(const Camera& camera);

  // `position_mm`: rig frame, NaN where nothing was measured. `to_camera`: unit; rays start a
  // little in front of the surface, towards the camera, where there is surely air. `step_px`:
  // between nodes; the shadow caster has vertices twice as close.
  LightVisibility(const Image3& position_mm, const Image3& to_camera, const LightStage& stage,
                  const Vec3d& projector_centre_mm, int step_px = kLeastStep_px);

  int step_px() const { return step_px_; }

  // The projector's index, after those of the LEDs.
  int projector() const { return light_count_ - 1; }

  // One byte a light, 1 where it reaches the node at pixel (column, row) x step_px().
  const uint8_t* node(int row, int column) const {
    return &reaches_[(size_t(row) * size_t(columns_) + size_t(column)) * size_t(light_count_)];
  }

  // The four nodes around a pixel and their bilinear weights.
  struct Corners {
    const uint8_t* node[4];
    float weight[4];
  };
  Corners corners(int y, int x) const;

  // Share of a light that reaches the pixel, 0 to 1.
  float share(int y, int x, int light) const;

 private:
  int step_px_ = kLeastStep_px, rows_ = 0, columns_ = 0, light_count_ = 0;
  std::vector<uint8_t> reaches_;
};

}  // namespace lamella::fit
