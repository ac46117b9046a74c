#include "twin/surface.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace lamella::twin {

namespace {

constexpr float kOutside = 190.f;    // no subject is larger, mm
constexpr float kMeanRadius = 95.f;  // that `spacing_mm` is meant at
constexpr int kCoarse = 6;           // rows and columns of fine grid per coarse one
constexpr float kLowestElevation = -0.7854f;

struct Ray {
  Vec3 origin, direction;
};

// Directions that find the surface: a sphere of them about the centre down to 45 degrees below the
// horizon, then cones whose apex slides down the axis.
class RayGrid {
 public:
  RayGrid(const Subject& subject, float spacing_mm) : subject_(subject) {
    step_rad_ = spacing_mm / kMeanRadius;
    const bool star = subject.axis_length_mm <= 0;
    lowest_ = star ? -kPi / 2 + step_rad_ : kLowestElevation;
    fan_rows_ = int((kPi / 2 - step_rad_ - lowest_) / step_rad_);
    slide_mm_ = spacing_mm * 1.4f;
    rows_ = fan_rows_ + (star ? 0 : int(subject.axis_length_mm / slide_mm_));
    for (float a = -kPi; a < kPi;) {
      azimuth_.push_back(a);
      a += step_rad_ * (std::abs(a) < 2.0f ? 1.f : 8.f);
    }
  }

  int rows() const { return rows_; }
  int columns() const { return int(azimuth_.size()); }

  Ray ray(int row, int column) const {
    const float elevation = std::max(lowest_, kPi / 2 - step_rad_ * float(row + 1));
    const float slid = slide_mm_ * float(std::max(0, row - fan_rows_));
    const float a = azimuth_[size_t(column)];
    const float c = std::cos(elevation);
    return {subject_.centre_mm - Vec3(0, slid, 0),
            {c * std::sin(a), std::sin(elevation), c * std::cos(a)}};
  }

 private:
  const Subject& subject_;
  float step_rad_, lowest_, slide_mm_;
  int fan_rows_, rows_;
  std::vector<float> azimuth_;
};

// From outside inwards to the first surface: distance from the ray's origin.
float trace_inwards(const Subject& subject, const Ray& ray) {
  float t = kOutside;
  for (int i = 0; i < 160 && t > 1.f; ++i) {
    const float d = subject.distance_mm(ray.origin + ray.direction * t);
    if (d < 0.01f) break;
    t -= 0.7f * d;
  }
  return t;
}

// From a guess near the surface: secant steps, held to the distance that is safe.
float refine(const Subject& subject, const Ray& ray, float t) {
  float d = subject.distance_mm(ray.origin + ray.direction * t), slope = 0.7f;
  for (int i = 0; i < 12 && std::abs(d) > 1e-3f; ++i) {
    const float step = std::clamp(d / slope, -3.f, 3.f);
    const float next = subject.distance_mm(ray.origin + ray.direction * (t - step));
    if (std::abs(step) > 1e-4f) slope = std::clamp((d - next) / step, 0.25f, 1.2f);
    t -= step;
    d = next;
  }
  return t;
}

std::vector<float> trace_grid(const Subject& subject, const RayGrid& grid) {
  const int rows = grid.rows(), columns = grid.columns();
  const int coarse_rows = rows / kCoarse + 2, coarse_columns = columns / kCoarse + 2;
  std::vector<float> coarse(size_t(coarse_rows) * size_t(coarse_columns));
  const auto fine_ray = [&](int row, int column) {
    return grid.ray(std::min(row, rows - 1), std::min(column, columns - 1));
  };
  parallel_for(coarse_rows, [&](int i) {
    for (int j = 0; j < coarse_columns; ++j) {
      coarse[size_t(i * coarse_columns + j)] =
          trace_inwards(subject, fine_ray(i * kCoarse, j * kCoarse));
    }
  });
  std::vector<float> distance(size_t(rows) * size_t(columns));
  parallel_for(
      rows,
      [&](int row) {
        for (int column = 0; column < columns; ++column) {
          const int i = row / kCoarse, j = column / kCoarse;
          const float u = float(row % kCoarse) / kCoarse, v = float(column % kCoarse) / kCoarse;
          const float* c = &coarse[size_t(i * coarse_columns + j)];
          const float guess = (1 - u) * ((1 - v) * c[0] + v * c[1]) +
                              u * ((1 - v) * c[coarse_columns] + v * c[coarse_columns + 1]);
          distance[size_t(row * columns + column)] = refine(subject, grid.ray(row, column), guess);
        }
      },
      4);
  return distance;
}

void add_geometry(const Subject& subject, Surface* s) {
  s->normal.resize(s->size());
  s->shading_normal.resize(s->size());
  s->area_mm2.resize(s->size());
  parallel_for(
      s->rows,
      [&](int row) {
        for (int column = 0; column < s->columns; ++column) {
          const int above = std::max(row - 1, 0), below = std::min(row + 1, s->rows - 1);
          const Vec3 down = s->position_mm[size_t(s->at(below, column))] -
                            s->position_mm[size_t(s->at(above, column))];
          const Vec3 across = s->position_mm[size_t(s->at(row, column + 1))] -
                              s->position_mm[size_t(s->at(row, column - 1))];
          const Vec3 n = cross(down, across);
          const size_t i = size_t(s->at(row, column));
          s->normal[i] = unit(n);
          s->area_mm2[i] = length(n) * 0.5f / float(below - above);
          s->shading_normal[i] = subject.shading_normal(s->position_mm[i], s->normal[i]);
        }
      },
      8);
}

void add_triangles(Surface* s) {
  s->triangles.reserve(size_t(s->rows) * size_t(s->columns) * 2);
  for (int row = 0; row + 1 < s->rows; ++row) {
    for (int column = 0; column < s->columns; ++column) {
      const int a = s->at(row, column), b = s->at(row, column + 1);
      const int c = s->at(row + 1, column), d = s->at(row + 1, column + 1);
      s->triangles.emplace_back(a, c, d);
      s->triangles.emplace_back(a, d, b);
    }
  }
}

}  // namespace

Surface make_surface(const Subject& subject, float spacing_mm) {
  const RayGrid grid(subject, spacing_mm);
  Surface s;
  s.rows = grid.rows();
  s.columns = grid.columns();
  const std::vector<float> distance = trace_grid(subject, grid);
  s.position_mm.resize(distance.size());
  parallel_for(s.rows, [&](int row) {
    for (int column = 0; column < s.columns; ++column) {
      const size_t i = size_t(s.at(row, column));
      const Ray ray = grid.ray(row, column);
      s.position_mm[i] = ray.origin + ray.direction * distance[i];
    }
  });
  add_geometry(subject, &s);
  add_triangles(&s);
  s.scene = std::make_unique<RayScene>(s.position_mm, s.triangles);
  return s;
}

}  // namespace lamella::twin
