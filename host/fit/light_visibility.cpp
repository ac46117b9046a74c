#include "fit/light_visibility.h"

namespace lamella::fit {

int LightVisibility::node(int row, int column) const {
  const cv::Mat1i& index = around_.index;
  return row < index.rows && column < index.cols ? index(row, column) : -1;
}

LightVisibility::Corners LightVisibility::corners(int y, int x) const {
  const int row = y / step_px(), column = x / step_px();
  return {node(row, column), node(row, column + 1), node(row + 1, column),
          node(row + 1, column + 1)};
}

std::array<float, 4> LightVisibility::weights(int y, int x) const {
  const int step = step_px();
  const float fy = float(y % step) / float(step), fx = float(x % step) / float(step);
  return {(1 - fy) * (1 - fx), (1 - fy) * fx, fy * (1 - fx), fy * fx};
}

float LightVisibility::projector_share(int y, int x) const {
  const Corners at = corners(y, x);
  const std::array<float, 4> weight = weights(y, x);
  float hidden = 0, total = 0;
  for (size_t k = 0; k < 4; ++k) {
    if (at[k] < 0) continue;
    total += weight[k];
    if (around_.projector_hidden[size_t(at[k])]) hidden += weight[k];
  }
  return total > 0 ? 1 - hidden / total : 1.f;
}

}  // namespace lamella::fit
