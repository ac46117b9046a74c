// What the face hides from itself: towards each LED and the projector, from a coarse grid of points
// on it. Everything that the left camera saw casts shadows; what it did not see casts none.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/camera.h"
#include "base/light_stage.h"
#include "base/vec.h"

namespace lamella::fit {

struct Surroundings {
  static constexpr int32_t kFree = -1;     // the LED is seen
  static constexpr int32_t kUnknown = -2;  // hidden by something whose photographed side is away
  static constexpr int32_t kBehind = -3;   // below the horizon: nobody looked

  static constexpr int kLeastStep_px = 6;

  // Pixels between nodes that are fine enough for a face, seen by `camera`.
  static int step_for(const Camera& camera);

  int step_px = kLeastStep_px;   // between nodes
  cv::Mat1i index;               // of the node at (row, column) x step_px; -1: none
  std::vector<cv::Point> pixel;  // of each node
  std::vector<int32_t> blocker;  // node x LED: pixel (y * columns + x) of what is in the way
  std::vector<uint8_t> projector_hidden;  // of each node: 1 where something is in the way
  size_t leds = 0;

  int32_t at(size_t node, size_t led) const { return blocker[node * leds + led]; }
  bool hidden(size_t node, size_t led) const {
    return at(node, led) >= 0 || at(node, led) == kUnknown;
  }
};

// Nodes wherever `position_mm` has a number, `step_px` apart; nothing is in the way yet.
Surroundings place_nodes(const Image3& position_mm, const LightStage& stage,
                         int step_px = Surroundings::kLeastStep_px);

// Rays from every node to the lights above its horizon, against the mesh of `scene_mm`. `normal`:
// unit, read at the nodes.
void look_around(const Image3& scene_mm, const Image3& normal, const LightStage& stage,
                 const Vec3d& projector_centre_mm, Surroundings* around);

// Nodes around a pixel, with weights that sum to 1 (0 where there is no node near).
struct NodeBlend {
  std::array<int, 4> node{};
  std::array<float, 4> weight{};
};
NodeBlend blend_nodes(const Surroundings& around, const Image1& distance_mm, int y, int x,
                      float px_mm);

// Solid angle (sr) around each LED: of all directions, those that are nearer to it than to others.
std::vector<float> solid_angles(const LightStage& stage);

}  // namespace lamella::fit
