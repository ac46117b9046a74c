// Monte Carlo of light in one homogeneous half-space of index 1.38: what model/half_space.h has
// tabulated, walked anew.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "model/fresnel.h"
#include "model/half_space.h"

namespace lamella::testing {

// Lengths in units of 1/mu_s'; light that was scattered once keeps its polarization and is left
// out.
class HalfSpaceWalk {
 public:
  explicit HalfSpaceWalk(double g) : g_(g), sum_(kRows * kColumns) {}

  void walk(int photons, unsigned seed) {
    std::mt19937 random(seed);
    for (int i = 0; i < photons; ++i) launch(&random);
    photons_ += photons;
  }

  // Share of a wave that is left; at row `row`, column `column` of the table.
  double transfer(int row, int column) const { return sum(row, column) / sum(row, 0); }

  double reflectance(int row) const { return sum(row, 0) / photons_; }

 private:
  // The first column is of even light.
  static constexpr int kRows = model::HalfSpaceTable::kAbsorptions;
  static constexpr int kColumns = model::HalfSpaceTable::kFrequencies + 1;
  static constexpr double kLongest = 12000, kFurthest = 400;

  struct Photon {
    double x = 0, y = 0, z = 0, dx = 0, dy = 0, dz = 1, path = 0;
    int scatterings = 0;
  };

  static double uniform(std::mt19937* random) { return (double((*random)()) + 0.5) / 4294967296.0; }

  // Share that the surface reflects back into the skin, which light meets at this cosine.
  static double kept_inside(double cosine) {
    const double sine = model::kSkinIor * std::sqrt(std::max(0.0, 1 - cosine * cosine));
    return sine < 1 ? model::fresnel_reflectance(std::sqrt(1 - sine * sine)) : 1;
  }

  double sum(int row, int column) const { return sum_[size_t(row * kColumns + column)]; }

  void launch(std::mt19937* random) {
    Photon p;
    while (p.path < kLongest && p.x * p.x + p.y * p.y < kFurthest * kFurthest) {
      if (!fly(&p, -std::log(uniform(random)) * (1 - g_), random)) return;
      ++p.scatterings;
      turn(&p, random);
    }
  }

  // False when the photon has left.
  bool fly(Photon* p, double distance, std::mt19937* random) {
    while (p->dz < 0 && distance > -p->z / p->dz) {
      const double to_surface = -p->z / p->dz;
      move(p, to_surface);
      p->z = 0;
      distance -= to_surface;
      if (uniform(random) >= kept_inside(-p->dz)) {
        if (p->scatterings > 1) record(*p);
        return false;
      }
      p->dz = -p->dz;
    }
    move(p, distance);
    return true;
  }

  static void move(Photon* p, double distance) {
    p->x += p->dx * distance;
    p->y += p->dy * distance;
    p->z += p->dz * distance;
    p->path += distance;
  }

  void turn(Photon* p, std::mt19937* random) const {
    const double t = (1 - g_ * g_) / (1 - g_ + 2 * g_ * uniform(random));
    const double cosine = std::clamp((1 + g_ * g_ - t * t) / (2 * g_), -1.0, 1.0);
    const double sine = std::sqrt(1 - cosine * cosine), phi = 2 * M_PI * uniform(random);
    const double c = std::cos(phi), s = std::sin(phi);
    const double planar = std::sqrt(std::max(0.0, 1 - p->dz * p->dz));
    if (planar < 1e-6) {
      p->dx = sine * c, p->dy = sine * s, p->dz = std::copysign(cosine, p->dz * cosine);
      return;
    }
    const double k = sine / planar;
    const double dx = k * (p->dx * p->dz * c - p->dy * s) + p->dx * cosine;
    const double dy = k * (p->dy * p->dz * c + p->dx * s) + p->dy * cosine;
    const double dz = -sine * c * planar + p->dz * cosine;
    const double norm = 1 / std::sqrt(dx * dx + dy * dy + dz * dz);
    p->dx = dx * norm, p->dy = dy * norm, p->dz = dz * norm;
  }

  void record(const Photon& p) {
    const double r = std::hypot(p.x, p.y), entered = 1 - model::fresnel_at_normal();
    std::array<double, kColumns> wave;
    wave[0] = 1;
    for (int j = 1; j < kColumns; ++j) {
      wave[size_t(j)] = std::cyl_bessel_j(
          0.0, 2 * M_PI * r * std::exp(model::HalfSpaceTable::log_frequency(j - 1)));
    }
    for (int i = 0; i < kRows; ++i) {
      const double left =
          entered * std::exp(-std::exp(model::HalfSpaceTable::log_absorption(i)) * p.path);
      for (int j = 0; j < kColumns; ++j) sum_[size_t(i * kColumns + j)] += left * wave[size_t(j)];
    }
  }

  double g_, photons_ = 0;
  std::vector<double> sum_;
};

}  // namespace lamella::testing
