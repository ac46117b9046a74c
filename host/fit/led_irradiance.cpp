#include "fit/led_irradiance.h"

#include <algorithm>

#include "base/parallel.h"

namespace lamella::fit {

namespace {

float sign_of(float a) { return a < 0 ? -1.f : 1.f; }

Vec3 normal_of(int column, int row, int cells) {
  const float a = 2.f * float(column) / (cells - 1) - 1, b = 2.f * float(row) / (cells - 1) - 1;
  const float z = 1 - std::abs(a) - std::abs(b);
  if (z >= 0) return unit({a, b, z});
  return unit({(1 - std::abs(b)) * sign_of(a), (1 - std::abs(a)) * sign_of(b), z});
}

cv::Vec2f cell_of(const Vec3& n, int cells) {
  const float sum = std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]);
  float a = n[0] / sum, b = n[1] / sum;
  if (n[2] < 0) {
    const float folded = (1 - std::abs(b)) * sign_of(a);
    b = (1 - std::abs(a)) * sign_of(b);
    a = folded;
  }
  return {0.5f * (a + 1) * (cells - 1), 0.5f * (b + 1) * (cells - 1)};
}

std::vector<Vec3> table_at(const LightStage& stage, const Vec3& x_mm, int cells) {
  std::vector<Vec3> table(size_t(cells * cells), Vec3(0, 0, 0));
  std::vector<Vec3> towards, irradiance;
  for (size_t i = 0; i < stage.leds().size(); ++i) {
    towards.push_back(stage.direction_from(i, x_mm));
    irradiance.push_back(stage.irradiance(i, x_mm));
  }
  parallel_for(cells, [&](int row) {
    for (int column = 0; column < cells; ++column) {
      const Vec3 n = normal_of(column, row, cells);
      Vec3& sum = table[size_t(row * cells + column)];
      for (size_t i = 0; i < towards.size(); ++i) {
        sum += irradiance[i] * std::max(0.f, dot(n, towards[i]));
      }
    }
  });
  return table;
}

}  // namespace

LedIrradiance::LedIrradiance(const LightStage& stage, const Vec3& low_mm, const Vec3& high_mm,
                             int cells)
    : low_mm_(low_mm), size_mm_(high_mm - low_mm), cells_(cells) {
  const bool near = std::any_of(stage.leds().begin(), stage.leds().end(),
                                [](const Led& led) { return led.distance_mm > 0; });
  for (int corner = 0; corner < (near ? 8 : 1); ++corner) {
    Vec3 x = low_mm;
    for (int a = 0; a < 3; ++a) {
      if (corner >> a & 1) x[a] += size_mm_[a];
    }
    tables_.push_back(table_at(stage, x, cells));
  }
}

Vec3 LedIrradiance::look_up(size_t table, const Vec3& n) const {
  const cv::Vec2f cell = cell_of(n, cells_);
  const int x = std::clamp(int(cell[0]), 0, cells_ - 2),
            y = std::clamp(int(cell[1]), 0, cells_ - 2);
  const float fx = cell[0] - float(x), fy = cell[1] - float(y);
  const Vec3* row = &tables_[table][size_t(y * cells_ + x)];
  return (row[0] * (1 - fx) + row[1] * fx) * (1 - fy) +
         (row[cells_] * (1 - fx) + row[cells_ + 1] * fx) * fy;
}

Vec3 LedIrradiance::at(const Vec3& n, const Vec3& x_mm) const {
  if (tables_.size() == 1) return look_up(0, n);
  Vec3 sum(0, 0, 0), f;
  for (int a = 0; a < 3; ++a) {
    f[a] = size_mm_[a] > 0 ? std::clamp((x_mm[a] - low_mm_[a]) / size_mm_[a], 0.f, 1.f) : 0.f;
  }
  for (size_t corner = 0; corner < 8; ++corner) {
    float weight = 1;
    for (int a = 0; a < 3; ++a) weight *= corner >> a & 1 ? f[a] : 1 - f[a];
    if (weight > 0) sum += look_up(corner, n) * weight;
  }
  return sum;
}

LedIrradiance led_irradiance_over(const LightStage& stage, const Image3& position_mm, int cells) {
  Vec3 low(1e9f, 1e9f, 1e9f), high = -low;
  for (int y = 0; y < position_mm.rows; y += 4) {
    for (int x = 0; x < position_mm.cols; x += 4) {
      const Vec3& p = position_mm(y, x);
      if (!is_finite(p)) continue;
      for (int a = 0; a < 3; ++a) {
        low[a] = std::min(low[a], p[a]);
        high[a] = std::max(high[a], p[a]);
      }
    }
  }
  return {stage, low, high, cells};
}

}  // namespace lamella::fit
