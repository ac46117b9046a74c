#include "render/diffuse.h"

#include <algorithm>

#include "base/parallel.h"

namespace lamella::render {

namespace {

constexpr float kOpening = 0.4f;

double dipole(double r, double ap, double ld, double A = 3.112) {
  const double s = std::sqrt(3 * (1 - ap)), st = 1 / ld, zr = s * ld, zv = zr * (1 + 4 * A / 3);
  const double dr = std::hypot(r, zr), dv = std::hypot(r, zv);
  return ap / (4 * M_PI) * (zr * (st + 1 / dr) * std::exp(-st * dr) / (dr * dr) +
                            zv * (st + 1 / dv) * std::exp(-st * dv) / (dv * dv));
}

}  // namespace

Visibility::Visibility(const Surface& surface, const Lights& lights)
    : words_((lights.size() + 63) / 64), bits_(surface.normal.size() * words_) {
  parallel_for(int(surface.normal.size()), [&](int v) {
    const Vec3& x = surface.mesh.vertices_mm[v];
    const Vec3 start = above_surface(x, surface.normal[v]);
    for (size_t i = 0; i < lights.size(); ++i) {
      const Incident light = lights.at(i, x);
      if (dot(light.direction, surface.normal[v]) <= 0) continue;
      if (surface.rays.occluded(start, light.direction, 0.01f, light.distance_mm)) continue;
      bits_[size_t(v) * words_ + i / 64] |= uint64_t(1) << (i % 64);
    }
  }, 256);
}

std::vector<Vec3> irradiance(const Surface& surface, const Lights& lights,
                             const Visibility& visibility) {
  std::vector<Vec3> result(surface.normal.size(), Vec3(0, 0, 0));
  parallel_for(int(result.size()), [&](int v) {
    for (size_t i = 0; i < lights.size(); ++i) {
      if (visibility(i, v) == 0) continue;
      const Incident light = lights.at(i, surface.mesh.vertices_mm[v]);
      result[v] += light.irradiance * std::max(0.f, dot(light.direction, surface.normal[v]));
    }
  }, 256);
  return result;
}

SpreadLight spread(const Subject& subject, const Surface& surface,
                   const std::vector<Vec3>& irradiance) {
  const size_t count = irradiance.size();
  std::vector<SurfaceSample> samples(count);
  for (size_t v = 0; v < count; ++v) {
    samples[v] = {surface.mesh.vertices_mm[v], surface.area_mm2[v], irradiance[v]};
  }
  const ClusterTree tree(samples, kOpening);
  std::vector<std::array<RadialKernel, 3>> kernels;
  for (size_t label = 0; label < subject.region_names.size(); ++label) {
    std::vector<RadialKernel> k;
    for (int c = 0; c < 3; ++c) {
      const double a = getenv("AP") ? atof(getenv("AP")) : 0.9;
      k.emplace_back([a](double r) { return dipole(r, a, 1); }, 8);
    }
    kernels.push_back({k[0], k[1], k[2]});
  }
  SpreadLight result{irradiance, irradiance};
  parallel_for(int(count), [&](int n) {
    const int v = tree.order()[n];
    const int label = surface.region[v] ? surface.region[v] : 1;
    const Vec3 ld = subject.maps.deep_ld_mm(surface.mesh.pixel[v]);
    if (!is_finite(ld)) return;
    ExitKernels exit;
    for (int c = 0; c < 3; ++c) exit.kernel[c] = &kernels[label][c];
    exit.scale_mm = ld;
    const Gathered g = tree.gather(surface.mesh.vertices_mm[v], exit);
    for (int c = 0; c < 3; ++c) {
      if (g.weight[c] > 0) result.deep[v][c] = g.light[c] / g.weight[c];
    }
  }, 256);
  return result;
}

}  // namespace lamella::render
