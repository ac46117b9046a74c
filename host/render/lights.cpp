#include "render/lights.h"

#include <algorithm>

#include "base/error.h"

namespace lamella::render {

namespace {

// Length of a shadow ray towards something far away; longer than any subject.
constexpr float kFarMm = 1e5f;

struct Cell {
  Vec3 irradiance{0, 0, 0};
  Vec3 weighted_direction{0, 0, 0};
};

// Rings of latitude of equal height in angle, each cut into cells about as wide as it is high.
class SphereCells {
 public:
  explicit SphereCells(int count) {
    rings_ = std::max(2, int(std::lround(std::sqrt(count * kPi / 4.f))));
    int first = 0;
    for (int i = 0; i < rings_; ++i) {
      const float polar = (i + 0.5f) * kPi / rings_;
      const int cells = std::max(3, int(std::lround(2 * rings_ * std::sin(polar))));
      first_.push_back(first);
      first += cells;
    }
    first_.push_back(first);
  }

  int size() const { return first_.back(); }

  // `polar` and `azimuth` as shares of their full turn, in [0, 1).
  int index(float polar, float azimuth) const {
    const int ring = std::min(rings_ - 1, int(polar * rings_));
    const int cells = first_[ring + 1] - first_[ring];
    return first_[ring] + std::min(cells - 1, int(azimuth * cells));
  }

 private:
  int rings_;
  std::vector<int> first_;
};

}  // namespace

std::vector<LightSample> cut_environment(const Image3& lat_long, int cells) {
  const SphereCells sphere(cells);
  std::vector<Cell> sums(sphere.size());
  for (int i = 0; i < lat_long.rows; ++i) {
    const float top = i * kPi / lat_long.rows, bottom = (i + 1) * kPi / lat_long.rows;
    const float solid_angle = 2 * kPi / lat_long.cols * (std::cos(top) - std::cos(bottom));
    const float polar = 0.5f * (top + bottom);
    for (int j = 0; j < lat_long.cols; ++j) {
      const float share = (j + 0.5f) / lat_long.cols;
      const float azimuth = (0.5f - share) * 2 * kPi;  // from +Z, positive towards +X
      const Vec3 direction{std::sin(polar) * std::sin(azimuth), std::cos(polar),
                           std::sin(polar) * std::cos(azimuth)};
      Cell& cell = sums[sphere.index(polar / kPi, share)];
      const Vec3 irradiance = lat_long(i, j) * (solid_angle / kPi);
      cell.irradiance += irradiance;
      cell.weighted_direction += direction * mean(irradiance);
    }
  }
  std::vector<LightSample> samples;
  for (const Cell& cell : sums) {
    if (mean(cell.irradiance) <= 0) continue;
    samples.push_back({true, false, unit(cell.weighted_direction), cell.irradiance});
  }
  return samples;
}

Lights::Lights(const View& view, const LightStage& stage, const Camera& projector,
               int environment_cells)
    : projector_(projector) {
  for (const Light& light : view.lights) {
    switch (light.kind) {
      case Light::Kind::kPoint: {
        const float squared = dot(light.position_mm, light.position_mm);
        samples_.push_back({false, false, light.position_mm, light.radiance_at_origin * squared});
        break;
      }
      case Light::Kind::kLeds:
        add_leds(light, stage);
        break;
      case Light::Kind::kProjector: {
        const Vec3 centre = projector.centre_mm();
        const float squared = dot(centre, centre);
        samples_.push_back({false, true, centre, Vec3::all(squared)});
        break;
      }
      case Light::Kind::kEnvironment: {
        const auto cells = cut_environment(read_exr_rgb(light.file), environment_cells);
        samples_.insert(samples_.end(), cells.begin(), cells.end());
        break;
      }
    }
  }
}

void Lights::add_leds(const Light& light, const LightStage& stage) {
  for (size_t i = 0; i < light.weights.size(); ++i) {
    if (light.weights[i] <= 0) continue;
    const Led& led = stage.leds()[i];
    const Vec3 at_origin = stage.irradiance(i, Vec3(0, 0, 0)) * light.weights[i];
    if (led.distance_mm > 0) {
      samples_.push_back({false, false, led.direction * led.distance_mm,
                          at_origin * (led.distance_mm * led.distance_mm)});
    } else {
      samples_.push_back({true, false, led.direction, at_origin});
    }
  }
}

Incident Lights::at(size_t i, const Vec3& x_mm) const {
  const LightSample& sample = samples_[i];
  if (sample.far) return {sample.place, sample.strength, kFarMm};
  const Vec3 to_light = sample.place - x_mm;
  const float distance = length(to_light);
  Incident light{to_light * (1 / distance), sample.strength * (1 / (distance * distance)),
                 distance};
  if (sample.framed) {
    const cv::Vec2d uv = projector_.project(x_mm);
    const bool inside = uv[0] >= -0.5 && uv[1] >= -0.5 && uv[0] < projector_.width - 0.5 &&
                        uv[1] < projector_.height - 0.5;
    if (!inside) light.irradiance = Vec3(0, 0, 0);
  }
  return light;
}

}  // namespace lamella::render
