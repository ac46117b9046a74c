#include "render/diffuse.h"

#include <algorithm>

#include "base/parallel.h"

namespace lamella::render {

namespace {

constexpr float kOpening = 0.3f;

// Light gathered with a kernel, or what enters at the place itself where there is no kernel.
Vec3 answer(const ClusterTree& tree, const Vec3& position_mm, const ExitKernels& kernels,
            const Vec3& local) {
  if (!kernels.any()) return local;
  const Gathered sum = tree.gather(position_mm, kernels);
  Vec3 result = local;
  for (int c = 0; c < 3; ++c) {
    if (sum.weight[c] > 0) result[c] = sum.light[c] / sum.weight[c];
  }
  return result;
}

}  // namespace

Visibility::Visibility(const Surface& surface, const Lights& lights)
    : words_((lights.size() + 63) / 64), bits_(surface.normal.size() * words_) {
  parallel_for(
      int(surface.normal.size()),
      [&](int v) {
        const Vec3& x = surface.mesh.vertices_mm[v];
        for (size_t i = 0; i < lights.size(); ++i) {
          const Incident light = lights.at(i, x);
          if (dot(light.direction, surface.normal[v]) <= 0) continue;
          if (shaded(surface, x, surface.normal[v], light.direction, light.distance_mm)) continue;
          bits_[size_t(v) * words_ + i / 64] |= uint64_t(1) << (i % 64);
        }
      },
      256);
}

std::vector<Vec3> irradiance(const Surface& surface, const Lights& lights,
                             const Visibility& visibility) {
  std::vector<Vec3> result(surface.normal.size(), Vec3(0, 0, 0));
  parallel_for(
      int(result.size()),
      [&](int v) {
        for (size_t i = 0; i < lights.size(); ++i) {
          if (visibility(i, v) == 0) continue;
          const Incident light = lights.at(i, surface.mesh.vertices_mm[v]);
          result[v] += light.irradiance * std::max(0.f, dot(light.direction, surface.normal[v]));
        }
      },
      256);
  return result;
}

SpreadLight spread(const RegionKernels& kernels, const Surface& surface,
                   const std::vector<Vec3>& irradiance) {
  const size_t count = irradiance.size();
  std::vector<SurfaceSample> samples(count);
  for (size_t v = 0; v < count; ++v) {
    samples[v] = {surface.mesh.vertices_mm[v], surface.area_mm2[v], irradiance[v]};
  }
  const ClusterTree tree(samples, kOpening);
  SpreadLight result{irradiance, irradiance};
  parallel_for(
      int(count),
      [&](int n) {
        const int v = tree.order()[n];
        const Vec3& x = surface.mesh.vertices_mm[v];
        const int label = surface.region[v];
        result.shallow[v] = answer(tree, x, kernels.shallow(label), irradiance[v]);
        result.deep[v] = answer(tree, x, kernels.deep(label, surface.ld_mm[v]), irradiance[v]);
      },
      256);
  return result;
}

}  // namespace lamella::render
