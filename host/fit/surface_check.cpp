#include "fit/surface_check.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "fit/order_statistics.h"

namespace lamella::fit {

namespace {

constexpr double kReach_mm =
    3;  // each way: less is the noise of the depths, more the subject's bends
constexpr size_t kFewestAngles = 100;

class SurfaceOfPositions {
 public:
  SurfaceOfPositions(const Burst& burst, const Geometry& geometry)
      : geometry_(geometry),
        labelled_(burst.regions),
        reach_px_(std::max(1, int(std::lround(kReach_mm / burst.session->left.pixel_mm())))) {}

  // Unit, towards the camera; NaN where it is not known.
  Vec3 normal(int y, int x) const {
    if (!is_measured(y, x)) return {kNaN, kNaN, kNaN};
    const Vec3 across = at(y, x + reach_px_) - at(y, x - reach_px_);
    const Vec3 down = at(y + reach_px_, x) - at(y - reach_px_, x);
    const Vec3 n = unit(across.cross(down));
    return dot(n, geometry_.to_camera(y, x)) < 0 ? n * -1.f : n;
  }

 private:
  bool is_measured(int y, int x) const {
    return y >= 0 && x >= 0 && y < labelled_.rows && x < labelled_.cols && labelled_(y, x) &&
           geometry_.measured(y, x);
  }

  Vec3 at(int y, int x) const {
    return is_measured(y, x) ? geometry_.position_mm(y, x) : Vec3(kNaN, kNaN, kNaN);
  }

  const Geometry& geometry_;
  const Labels& labelled_;
  int reach_px_;
};

}  // namespace

double normals_off_surface_deg(const Burst& burst, const Geometry& geometry,
                               const Normals& normals) {
  const SurfaceOfPositions surface(burst, geometry);
  std::vector<std::vector<float>> rows(size_t(burst.regions.rows));
  parallel_for(burst.regions.rows, [&](int y) {
    for (int x = 0; x < burst.regions.cols; ++x) {
      const float cosine = dot(surface.normal(y, x), normals.specular(y, x));
      if (is_finite(cosine)) rows[size_t(y)].push_back(cosine);
    }
  });
  std::vector<float> all;
  for (const std::vector<float>& row : rows) all.insert(all.end(), row.begin(), row.end());
  if (all.size() < kFewestAngles) return std::nan("");
  return std::acos(std::clamp(double(median_of(&all)), -1.0, 1.0)) * 180 / M_PI;
}

}  // namespace lamella::fit
