#include "twin/lighting.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace lamella::twin {

namespace {

constexpr float kOffSurface = 0.15f;  // mm, where shadow rays start above the surface
constexpr float kFar = 4000.f;

}  // namespace

LedVisibility::LedVisibility(const Surface& surface, const std::vector<Led>& leds)
    : surface_(surface), led_count_(leds.size()) {
  rows_ = (surface.rows - 1) / kStride + 2;
  columns_ = (surface.columns - 1) / kStride + 2;
  seen_.assign(size_t(rows_) * size_t(columns_) * led_count_, 0);
  parallel_for(rows_, [&](int i) {
    const int row = std::min(i * kStride, surface.rows - 1);
    for (int j = 0; j < columns_; ++j) {
      const size_t at = size_t(surface.at(row, std::min(j * kStride, surface.columns)));
      const Vec3 n = surface.normal[at];
      const Vec3 from = surface.position_mm[at] + n * kOffSurface;
      uint8_t* seen = &seen_[(size_t(i) * size_t(columns_) + size_t(j)) * led_count_];
      for (size_t led = 0; led < led_count_; ++led) {
        const Vec3 w = leds[led].direction;
        if (dot(n, w) <= -0.15f) continue;
        if (!surface.scene->occluded(from, w, 0.f, kFar)) seen[led] = 255;
      }
    }
  });
}

LedVisibility::Cell LedVisibility::cell(float grid_row, float grid_column) const {
  const float y = std::clamp(grid_row / kStride, 0.f, float(rows_ - 1) - 1e-3f);
  const float x = std::clamp(grid_column / kStride, 0.f, float(columns_ - 1) - 1e-3f);
  const int i = int(y), j = int(x);
  const float v = y - float(i), u = x - float(j);
  const int corner = i * columns_ + j;
  return {{corner, corner + 1, corner + columns_, corner + columns_ + 1},
          {(1 - v) * (1 - u), (1 - v) * u, v * (1 - u), v * u}};
}

LedVisibility::Corners LedVisibility::around(float grid_row, float grid_column) const {
  const Cell c = cell(grid_row, grid_column);
  Corners corners;
  for (int k = 0; k < 4; ++k) {
    corners.row[k] = &seen_[size_t(c.corner[k]) * led_count_];
    corners.weight[k] = c.weight[k];
  }
  return corners;
}

std::vector<Vec3> LedVisibility::net_light(const std::vector<float>& levels,
                                           const LightStage& stage) const {
  std::vector<Vec3> net(size_t(rows_) * size_t(columns_));
  parallel_for(rows_, [&](int i) {
    const int row = std::min(i * kStride, surface_.rows - 1);
    for (int j = 0; j < columns_; ++j) {
      const size_t vertex = size_t(i) * size_t(columns_) + size_t(j);
      const size_t at = size_t(surface_.at(row, std::min(j * kStride, surface_.columns)));
      const Vec3 n = surface_.normal[at];
      Vec3 sum(0, 0, 0);
      for (size_t led = 0; led < led_count_; ++led) {
        const Vec3 w = stage.leds()[led].direction;
        if (seen_[vertex * led_count_ + led] && dot(n, w) > 0.f) {
          sum += w * (levels[led] * stage.irradiance(led, surface_.position_mm[at])[0]);
        }
      }
      net[vertex] = sum;
    }
  });
  return net;
}

Vec3 LedVisibility::interpolate(const std::vector<Vec3>& coarse, float grid_row,
                                float grid_column) const {
  const Cell c = cell(grid_row, grid_column);
  Vec3 sum(0, 0, 0);
  for (int k = 0; k < 4; ++k) sum += coarse[size_t(c.corner[k])] * c.weight[k];
  return sum;
}

std::vector<Vec3> led_irradiance(const Surface& surface, const LedVisibility& visibility,
                                 const LightStage& stage, const std::vector<float>& levels) {
  const std::vector<Vec3> net = visibility.net_light(levels, stage);
  std::vector<Vec3> irradiance(surface.size());
  parallel_for(
      surface.rows,
      [&](int row) {
        for (int column = 0; column < surface.columns; ++column) {
          const size_t i = size_t(surface.at(row, column));
          const Vec3 b = visibility.interpolate(net, float(row), float(column));
          irradiance[i] = Vec3::all(std::max(0.f, dot(surface.shading_normal[i], b)));
        }
      },
      8);
  return irradiance;
}

PointLight::PointLight(const Surface& surface, const Vec3& position_mm, double distance_of_one_mm)
    : surface_(surface),
      position_mm_(position_mm),
      distance_of_one_mm_(float(distance_of_one_mm)),
      vertex_irradiance_(surface.size()) {
  parallel_for(
      surface.rows,
      [&](int row) {
        for (int column = 0; column < surface.columns; ++column) {
          const size_t i = size_t(surface.at(row, column));
          const Vec3 x = surface.position_mm[i];
          const float cosine = dot(surface.shading_normal[i], direction(x));
          const bool lit = cosine > 0.f && sees(x, surface.normal[i]);
          vertex_irradiance_[i] = lit ? cosine * strength(x) : 0.f;
        }
      },
      8);
}

float PointLight::strength(const Vec3& x_mm) const {
  const Vec3 to_light = position_mm_ - x_mm;
  return distance_of_one_mm_ * distance_of_one_mm_ / dot(to_light, to_light);
}

bool PointLight::sees(const Vec3& x_mm, const Vec3& normal) const {
  const Vec3 l = direction(x_mm);
  if (dot(normal, l) <= 0.f) return false;
  return !surface_.scene->occluded(x_mm + normal * kOffSurface, l, 0.f, kFar);
}

}  // namespace lamella::twin
