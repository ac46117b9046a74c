#include "render/exit_kernels.h"

#include <algorithm>

#include "model/multipole.h"

namespace lamella::render {

namespace {

// Of the light of a dipole, less than 1e-3 leaves further away than this many mean free paths.
constexpr double kReach = 8;
// Reduced albedo of a region of which nothing is known; the shape of R(r) depends on it little.
constexpr double kUsualAlpha = 0.9;

double alpha_of_albedo(const Subject& subject, int label, int channel) {
  std::vector<float> values;
  const LayerMaps& maps = subject.maps;
  for (int i = 0; i < maps.regions.rows; i += 3) {
    for (int j = 0; j < maps.regions.cols; j += 3) {
      const float albedo = maps.deep_albedo(i, j)[channel];
      if (maps.regions(i, j) == label && is_finite(albedo)) values.push_back(albedo);
    }
  }
  if (values.empty()) return kUsualAlpha;
  const auto middle = values.begin() + long(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return model::alpha_from_reflectance(*middle).value_or(kUsualAlpha);
}

std::unique_ptr<RadialKernel> dipole_kernel(double alpha) {
  return std::make_unique<RadialKernel>(
      [alpha](double r) {
        return model::dipole_reflectance(model::Dipole<double>{alpha, 1}, r);
      },
      kReach);
}

std::unique_ptr<RadialKernel> multipole_kernel(double alpha, double thickness_per_ld) {
  const model::Multipole<double> slab{alpha, 1, thickness_per_ld};
  auto kernel = std::make_unique<RadialKernel>(
      [slab](double r) { return model::multipole_reflectance(slab, r); }, kReach);
  return kernel->valid() ? std::move(kernel) : nullptr;
}

}  // namespace

RegionKernels::RegionKernels(const Subject& subject) : regions_(subject.region_names.size()) {
  for (int label = 1; label < int(regions_.size()); ++label) {
    Region& region = regions_[label];
    const v1::Region* fitted = subject.region(label);
    for (int c = 0; c < 3; ++c) {
      const bool has_dot = fitted && fitted->deep().alpha_dot_size() == 3;
      const double alpha =
          has_dot ? fitted->deep().alpha_dot(c) : alpha_of_albedo(subject, label, c);
      region.deep[c] = dipole_kernel(std::clamp(alpha, 0.01, 0.9999));
      if (!fitted || fitted->shallow().ld_mm_size() != 3 || fitted->shallow().alpha_size() != 3) {
        continue;
      }
      const auto& shallow = fitted->shallow();
      if (!(shallow.ld_mm(c) > 0 && shallow.alpha(c) > 0)) continue;
      region.shallow_per_mm[c] = float(1 / shallow.ld_mm(c));
      region.shallow[c] = multipole_kernel(
          std::min(shallow.alpha(c), 0.9999),
          (shallow.has_thickness_mm() ? shallow.thickness_mm() : 0.5) / shallow.ld_mm(c));
    }
  }
}

ExitKernels RegionKernels::deep(int label, const Vec3& ld_mm) const {
  ExitKernels exit;
  for (int c = 0; c < 3; ++c) {
    if (!(ld_mm[c] > 0)) continue;
    exit.kernel[c] = regions_[label].deep[c].get();
    exit.per_mm[c] = 1 / ld_mm[c];
  }
  return exit;
}

ExitKernels RegionKernels::shallow(int label) const {
  ExitKernels exit;
  for (int c = 0; c < 3; ++c) exit.kernel[c] = regions_[label].shallow[c].get();
  exit.per_mm = regions_[label].shallow_per_mm;
  return exit;
}

}  // namespace lamella::render
