#include "fit/normals.h"

#include "base/parallel.h"

namespace lamella::fit {

namespace {

Vec3 ratios(const Burst& burst, int y, int x, int channel, bool polarized) {
  Vec3 r;
  const auto value = [&](const AnalyserPair& pair) {
    if (!polarized) return pair.cross(y, x)[channel];
    return mean(pair.parallel(y, x) - pair.cross(y, x));
  };
  const float full = std::max(1e-4f, value(burst.full));
  for (int a = 0; a < 3; ++a) r[a] = 2 * value(burst.gradient[size_t(a)]) / full - 1;
  return r;
}

}  // namespace

Normals estimate_normals(const Burst& burst, Geometry* geometry) {
  Normals n;
  const cv::Size size = burst.regions.size();
  const Vec3 nowhere(kNaN, kNaN, kNaN);
  n.specular = Image3(size, nowhere);
  for (Image3& d : n.diffuse) d = Image3(size, nowhere);
  n.specular_confidence = n.diffuse_confidence = n.ambient_visibility = Image1();
  n.specular_confidence = Image1(size, 0.f);
  n.diffuse_confidence = Image1(size, 0.f);
  n.ambient_visibility = Image1(size, 1.f);
  parallel_for(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      if (!burst.regions(y, x)) continue;
      n.specular(y, x) = unit(unit(ratios(burst, y, x, 0, true)) + geometry->to_camera(y, x));
      for (int c = 0; c < 3; ++c) n.diffuse[size_t(c)](y, x) = unit(ratios(burst, y, x, c, false));
      n.specular_confidence(y, x) = n.diffuse_confidence(y, x) = 0.5f;
    }
  });
  return n;
}

}  // namespace lamella::fit
