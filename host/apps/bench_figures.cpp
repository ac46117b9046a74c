#include "apps/bench_figures.h"

#include <fmt/format.h>

namespace lamella::apps {

const std::vector<BenchFigure>& bench_figures() {
  static const std::vector<BenchFigure> figures{
      {"position_median_mm", "position, median", "mm", {"/position/error_mm/median"}},
      {"position_rms_mm", "position, RMS", "mm", {"/position/error_mm/rms"}},
      {"specular_normal_median_deg",
       "specular normal, median",
       "degrees",
       {"/normal_specular/deg/median"}},
      {"diffuse_normal_median_deg",
       "diffuse normals, median",
       "degrees",
       {"/normal_diffuse/r/deg/median", "/normal_diffuse/g/deg/median",
        "/normal_diffuse/b/deg/median"}},
      {"c_rel_rmse", "c", "", {"/specular_intensity/all/rel_rmse"}},
      {"gaussian_m_abs_error_rad", "lobe width m", "rad", {"/summary/gaussian_m_mean_abs_error"}},
      {"p_l1", "p", "", {"/summary/p_L1_mean"}},
      {"single_rel_error",
       "single scattering",
       "",
       {"/summary/single_amplitude_mean_abs_rel_error"}},
      {"ld_rel_error", "l_d", "", {"/summary/ld_mean_abs_rel_error"}},
      {"shallow_albedo_rel_rmse",
       "shallow albedo",
       "",
       {"/shallow_albedo/error/0/rel_rmse", "/shallow_albedo/error/1/rel_rmse",
        "/shallow_albedo/error/2/rel_rmse"}},
      {"deep_albedo_rel_rmse",
       "deep albedo",
       "",
       {"/deep_albedo/error/0/rel_rmse", "/deep_albedo/error/1/rel_rmse",
        "/deep_albedo/error/2/rel_rmse"}},
      {"profile_l1", "R(r)", "", {"/summary/profile_L1_mean"}}};
  return figures;
}

std::vector<double> figures_of(const Json& comparison) {
  std::vector<double> values;
  for (const BenchFigure& figure : bench_figures()) {
    double sum = 0;
    int count = 0;
    for (const char* path : figure.paths) {
      if (!path) break;
      const Json::json_pointer at(path);
      const bool known = comparison.contains(at) && comparison[at].is_number();
      sum += known ? comparison[at].get<double>() : double(kNaN);
      ++count;
    }
    values.push_back(sum / count);
  }
  return values;
}

std::string csv_number(double value) {
  return std::isfinite(value) ? fmt::format("{:.6g}", value) : "";
}

std::string with_unit(double value, const std::string& unit) {
  if (!std::isfinite(value)) return "-";
  if (unit.empty()) return fmt::format("{:.3g} %", 100 * value);
  return fmt::format("{:.3g} {}", value, unit == "degrees" ? "deg" : unit);
}

}  // namespace lamella::apps
