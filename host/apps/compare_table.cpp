#include <fmt/core.h>

#include "apps/compare_confidence.h"
#include "apps/compare_folders.h"
#include "apps/report.h"

namespace lamella::apps {

namespace {

// The number at a path into the figures, times `scale`, or a dash.
std::string at(const Json& figures, const std::string& pointer, int digits, double scale = 1) {
  const Json::json_pointer path(pointer);
  if (!figures.contains(path) || !figures[path].is_number()) return "-";
  return decimals(figures[path].get<double>() * scale, digits);
}

// `name` as a part of a path: RFC 6901, section 3.
std::string step_to(const std::string& name) {
  std::string step = "/";
  for (const char c : name) step += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return step;
}

std::string percent(const Json& figures, const std::string& pointer, int digits = 1) {
  const std::string text = at(figures, pointer, digits, 100);
  return text == "-" ? text : text + " %";
}

void geometry_rows(const Json& f, std::string* out) {
  const auto row = [&](const char* map, const std::string& answered, const std::string& median,
                       const std::string& worst, const char* unit) {
    *out += fmt::format("  {:<20}{:>10}{:>10}{:>10}  {}\n", map, answered, median, worst, unit);
  };
  *out += fmt::format("  {:<20}{:>10}{:>10}{:>10}\n", "shape", "answered", "median", "95 %");
  row("position", percent(f, "/answered/position"), at(f, "/position/error_mm/median", 3),
      at(f, "/position/error_mm/p95", 3), "mm");
  row("  without worst 1 %", "", at(f, "/position/rms_trimmed99_mm", 3), "", "mm, RMS");
  row("specular normal", percent(f, "/answered/normal_specular"),
      at(f, "/normal_specular/deg/median", 2), at(f, "/normal_specular/deg/p95", 2), "degrees");
  for (const char* c : {"r", "g", "b"}) {
    const std::string path = std::string("/normal_diffuse/") + c + "/deg/";
    row((std::string("diffuse normal ") + c).c_str(), percent(f, "/answered/normal_diffuse"),
        at(f, path + "median", 2), at(f, path + "p95", 2), "degrees");
  }
}

void reflectance_rows(const Json& f, std::string* out) {
  *out += fmt::format("\n  {:<20}{:>10}{:>10}{:>10}{:>10}{:>14}\n", "reflectance", "answered",
                      "red", "green", "blue", "median ratio");
  const auto error = [&](const std::string& path) { return percent(f, path + "/rel_rmse"); };
  *out += fmt::format("  {:<20}{:>10}{:>10}{:>10}{:>10}{:>14}  relative RMSE\n", "specular c",
                      percent(f, "/answered/specular_intensity"), error("/specular_intensity/all"),
                      "", "", at(f, "/specular_intensity/all/median_ratio", 3));
  for (const char* map :
       {"single_albedo", "total_albedo", "shallow_albedo", "deep_albedo", "deep_alpha"}) {
    const std::string path = std::string("/") + map + "/error/";
    *out += fmt::format("  {:<20}{:>10}{:>10}{:>10}{:>10}{:>14}  relative RMSE\n", map,
                        percent(f, std::string("/answered/") + map), error(path + "0"),
                        error(path + "1"), error(path + "2"), at(f, path + "1/median_ratio", 3));
  }
}

std::string three_percents(const Json& f, const std::string& path) {
  std::string text;
  for (const char* c : {"/0", "/1", "/2"}) text += fmt::format("{:>7}", percent(f, path + c, 0));
  return text;
}

constexpr const char* kRegionRow = "  {:<13}{:>15}{:>9}{:>13}{:>13}{:>13}{:>9}{:>22}{:>22}\n";

void region_rows(const Json& f, std::string* out) {
  if (!f.contains("regions")) return;
  *out += "\n" + fmt::format(kRegionRow, "region", "m / true, rad", "p L1", "l_d red, mm", "green",
                             "blue", "c RMSE", "single, error r g b", "R(r), L1 r g b");
  for (const auto& [name, region] : f["regions"].items()) {
    const std::string r = "/regions" + step_to(name);
    const auto pair = [&](const std::string& a, const std::string& b, int digits) {
      return at(f, r + a, digits) + " / " + at(f, r + b, digits);
    };
    *out += fmt::format(
        kRegionRow, name, pair("/gaussian_m", "/gaussian_m_truth", 3), percent(f, r + "/p_L1"),
        pair("/ld_mm/0", "/ld_truth/0", 2), pair("/ld_mm/1", "/ld_truth/1", 2),
        pair("/ld_mm/2", "/ld_truth/2", 2),
        percent(f, "/specular_intensity/per_region" + step_to(name) + "/rel_rmse", 0),
        three_percents(f, r + "/single_amplitude_rel_error"), three_percents(f, r + "/profile_L1"));
  }
  *out +=
      fmt::format(kRegionRow, "mean error", at(f, "/summary/gaussian_m_mean_abs_error", 3),
                  percent(f, "/summary/p_L1_mean"), percent(f, "/summary/ld_mean_abs_rel_error"),
                  "", "", "", percent(f, "/summary/single_amplitude_mean_abs_rel_error"),
                  percent(f, "/summary/profile_L1_mean"));
}

// What to make of a curve that does not fall.
const char* confidence_words(const ConfidenceCurve& curve) {
  if (curve.falls) return "";
  return curve.bins.size() > 1 ? "  confidence does not order the errors"
                               : "  confidence is the same everywhere";
}

// The ends of the curves that --json has whole.
void confidence_rows(const Json& f, std::string* out) {
  const std::vector<ConfidenceCurve> curves = confidence_curves_of(f);
  if (curves.empty()) return;
  *out += fmt::format("\n  {:<20}{:>22}{:>22}\n  {:<20}{:>12}{:>10}{:>12}{:>10}\n", "error of the",
                      "least sure tenth", "surest tenth", "", "median", "95 %", "median", "95 %");
  for (const ConfidenceCurve& curve : curves) {
    const ConfidenceBin &least = curve.bins.front(), &most = curve.bins.back();
    *out += fmt::format("  {:<20}{:>12.3g}{:>10.3g}{:>12.3g}{:>10.3g}  {}{}\n", curve.label,
                        least.median_error, least.p95_error, most.median_error, most.p95_error,
                        unit_words(curve.unit), confidence_words(curve));
  }
}

void view_rows(const Json& f, std::string* out) {
  if (!f.contains("views") || f["views"].empty()) return;
  *out += fmt::format("\n  {:<20}{:>10}{:>10}{:>12}{:>10}\n", "view", "all", "seen", "best scale",
                      "PSNR");
  for (const auto& [name, view] : f["views"].items()) {
    const std::string v = "/views" + step_to(name);
    *out += fmt::format("  {:<20}{:>10}{:>10}{:>12}{:>10}  relative RMSE, dB\n", name,
                        percent(f, v + "/rel_rmse"), percent(f, v + "/rel_rmse_seen"),
                        at(f, v + "/best_scale", 3), at(f, v + "/psnr_srgb_db", 1));
  }
}

}  // namespace

std::string comparison_table(const Json& figures) {
  std::string out = fmt::format(
      "Recovered {} against true {}, {} labelled pixels\n\n", figures["fit"].get<std::string>(),
      figures["truth"].get<std::string>(), figures["labelled_pixels"].get<size_t>());
  geometry_rows(figures, &out);
  reflectance_rows(figures, &out);
  confidence_rows(figures, &out);
  region_rows(figures, &out);
  view_rows(figures, &out);
  for (const Json& problem : figures["problems"]) {
    out += fmt::format("\n  ! {}", problem.get<std::string>());
  }
  return out + (figures["problems"].empty() ? "" : "\n");
}

}  // namespace lamella::apps
