// How much of each light reaches a pixel past what the subject hides from itself, between the nodes
// that looked around.
#pragma once

#include <array>
#include <vector>

#include "fit/surroundings.h"

namespace lamella::fit {

// `around` must outlive it. Without a node near nothing is hidden.
class LightVisibility {
 public:
  explicit LightVisibility(const Surroundings& around) : around_(around) {}

  int step_px() const { return around_.step_px; }

  // The nodes around the cell of step_px() x step_px() pixels that a pixel is in; -1: none.
  using Corners = std::array<int, 4>;
  Corners corners(int y, int x) const;

  // Bilinear weights of the corners, at a pixel of the cell.
  std::array<float, 4> weights(int y, int x) const;

  // Share of an LED that reaches each corner: none where it is hidden or below the horizon, as what
  // hides it from the corner then, the slope that the corner lies on, is near. A corner that is no
  // node says what the others say.
  std::array<float, 4> reaches(const Corners& corners, size_t led) const {
    std::array<float, 4> reaches{};
    float sum = 0, nodes = 0;
    for (size_t k = 0; k < 4; ++k) {
      if (corners[k] < 0) continue;
      reaches[k] = around_.at(size_t(corners[k]), led) == Surroundings::kFree ? 1.f : 0.f;
      sum += reaches[k];
      ++nodes;
    }
    const float others = nodes > 0 ? sum / nodes : 1.f;
    for (size_t k = 0; k < 4; ++k) {
      if (corners[k] < 0) reaches[k] = others;
    }
    return reaches;
  }

  // Share of the projector's light that reaches the pixel, 0 to 1.
  float projector_share(int y, int x) const;

 private:
  int node(int row, int column) const;

  const Surroundings& around_;
};

}  // namespace lamella::fit
