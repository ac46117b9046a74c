#include "apps/compare_profile.h"

#include <functional>

#include "model/multipole.h"

namespace lamella::apps {

namespace {

constexpr double kFromMm = 0.1, kToMm = 8;

// Integral over the plane, a ring for each radius.
double plane_integral(const std::vector<double>& r_mm, const std::vector<double>& values) {
  double sum = 0;
  for (size_t i = 0; i < r_mm.size(); ++i) sum += values[i] * 2 * M_PI * r_mm[i];
  return sum * (r_mm[1] - r_mm[0]);
}

// Adds `profile` scaled to integrate to `albedo`; one without light is left out.
void add_layer(const std::vector<double>& r_mm, double albedo,
               const std::function<double(double)>& profile, std::vector<double>* sum) {
  std::vector<double> values;
  for (double r : r_mm) values.push_back(profile(r));
  const double whole = plane_integral(r_mm, values);
  if (!(whole > 0)) return;
  for (size_t i = 0; i < r_mm.size(); ++i) (*sum)[i] += albedo * values[i] / whole;
}

}  // namespace

double profile_L1(const v1::Region& fitted, int channel, double deep_albedo, double shallow_albedo,
                  const TrueProfile& truth) {
  const auto& deep = fitted.deep();
  if (channel >= deep.ld_mm_size() || channel >= deep.alpha_dot_size()) return kNaN;
  std::vector<double> sum(truth.r_mm.size(), 0.0);
  const model::Dipole<double> dipole{deep.alpha_dot(channel), deep.ld_mm(channel)};
  add_layer(
      truth.r_mm, deep_albedo, [&](double r) { return model::dipole_reflectance(dipole, r); },
      &sum);
  const auto& shallow = fitted.shallow();
  if (channel < shallow.ld_mm_size() && channel < shallow.alpha_size() &&
      shallow.ld_mm(channel) > 0 && shallow.alpha(channel) > 0) {
    const model::Multipole<double> slab{shallow.alpha(channel), shallow.ld_mm(channel),
                                        shallow.has_thickness_mm() ? shallow.thickness_mm() : 0.5};
    add_layer(
        truth.r_mm, shallow_albedo, [&](double r) { return model::multipole_reflectance(slab, r); },
        &sum);
  }
  const double scale =
      (deep_albedo + shallow_albedo) / plane_integral(truth.r_mm, truth.reflectance);
  double error = 0, whole = 0;
  for (size_t i = 0; i < sum.size(); ++i) {
    const double r = truth.r_mm[i], t = truth.reflectance[i] * scale;
    if (r <= kFromMm || r >= kToMm) continue;
    error += std::abs(sum[i] - t) * r;
    whole += t * r;
  }
  return error / whole;
}

}  // namespace lamella::apps
