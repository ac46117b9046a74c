#include "apps/compare_layers.h"

#include <algorithm>
#include <functional>

#include "apps/compare_npz.h"
#include "apps/compare_profile.h"
#include "base/error.h"

namespace lamella::apps {

namespace {

using List = google::protobuf::RepeatedField<double>;

double interpolate(const List& x, const List& y, double at) {
  const int last = std::min(x.size(), y.size()) - 1;
  if (at <= x[0]) return y[0];
  if (at >= x[last]) return y[last];
  const int i = int(std::upper_bound(x.begin(), x.begin() + last, at) - x.begin());
  return y[i - 1] + (y[i] - y[i - 1]) * (at - x[i - 1]) / (x[i] - x[i - 1]);
}

// Integral over the cone of the table: trapezoids of value 2 pi sin cos.
double cone_integral(const List& theta, const std::function<double(int)>& value) {
  const auto at = [&](int i) {
    return value(i) * 2 * M_PI * std::sin(theta[i]) * std::cos(theta[i]);
  };
  double sum = 0;
  for (int i = 1; i < theta.size(); ++i)
    sum += 0.5 * (at(i) + at(i - 1)) * (theta[i] - theta[i - 1]);
  return sum;
}

Json list_of(const List& values) {
  Json out = Json::array();
  for (double v : values) out.push_back(number(v));
  return out;
}

Json relative_errors(const List& found, const List& truth) {
  Json out = Json::array();
  for (int i = 0; i < std::min(found.size(), truth.size()); ++i) {
    out.push_back(truth[i] != 0 ? number(found[i] / truth[i] - 1) : Json());
  }
  return out;
}

void add_lobe(const v1::SpecularLobe& found, const v1::SpecularLobe& truth, Json* region) {
  if (found.has_gaussian_m()) {
    (*region)["gaussian_m"] = number(found.gaussian_m());
    (*region)["gaussian_m_truth"] = number(truth.gaussian_m());
    (*region)["gaussian_m_abs_error"] = number(std::abs(found.gaussian_m() - truth.gaussian_m()));
  }
  if (found.p_size() == 0 || found.theta_size() == 0 || truth.p_size() == 0) return;
  const auto p_true = [&](int i) { return truth.p(i); };
  const auto p_found = [&](int i) { return interpolate(found.theta(), found.p(), truth.theta(i)); };
  const auto error = [&](int i) { return std::abs(p_found(i) - p_true(i)); };
  const double whole = cone_integral(truth.theta(), p_true);
  (*region)["p_L1"] = number(cone_integral(truth.theta(), error) / whole);
  (*region)["p_peak_ratio"] = number(p_found(0) / p_true(0));
  (*region)["p_integral_0_45deg"] = number(cone_integral(truth.theta(), p_found));
  (*region)["p_integral_0_45deg_truth"] = number(whole);
}

const v1::Region* region_named(const v1::Layers& layers, const std::string& name) {
  for (const v1::Region& region : layers.regions()) {
    if (region.name() == name) return &region;
  }
  return nullptr;
}

Json region_figures(const v1::Region& found, const v1::Region& truth) {
  Json out{{"layers", nullptr}};
  add_lobe(found.specular(), truth.specular(), &out);
  if (found.deep().ld_mm_size() > 0) {
    out["ld_mm"] = list_of(found.deep().ld_mm());
    out["ld_truth"] = list_of(truth.deep().ld_mm());
    out["ld_rel_error"] = relative_errors(found.deep().ld_mm(), truth.deep().ld_mm());
    if (truth.deep().ld_dermis_mm_size() > 0) {
      out["ld_dermis_mm"] = list_of(truth.deep().ld_dermis_mm());
    }
  }
  if (found.has_layers()) {
    out["layers"] = {{"specular", found.layers().specular()},
                     {"single", found.layers().single()},
                     {"shallow", found.layers().shallow()},
                     {"deep", found.layers().deep()},
                     {"why", Json::object()}};
    for (const auto& [layer, why] : found.layers().why()) out["layers"]["why"][layer] = why;
  }
  if (found.single().amplitude_size() > 0 && truth.single().amplitude_size() > 0) {
    out["single_amplitude"] = list_of(found.single().amplitude());
    out["single_amplitude_rel_error"] =
        relative_errors(found.single().amplitude(), truth.single().amplitude());
  }
  return out;
}

// Mean over regions (and channels) of the size of a figure; null where no region has it.
Json mean_over_regions(const Json& regions, const char* figure) {
  double sum = 0;
  int count = 0;
  for (const auto& [name, region] : regions.items()) {
    if (!region.contains(figure)) continue;
    const Json values = region[figure].is_array() ? region[figure] : Json::array({region[figure]});
    for (const Json& v : values) {
      if (v.is_number()) sum += std::abs(v.get<double>()), ++count;
    }
  }
  return count ? Json(sum / count) : Json();
}

Json regions_without_a_figure(const Json& regions) {
  Json out = Json::array();
  for (const auto& [name, region] : regions.items()) {
    for (const char* figure : {"gaussian_m_abs_error", "p_L1", "ld_rel_error"}) {
      const bool there = region.contains(figure) && !region[figure].is_null();
      const bool gap = there && region[figure].is_array() &&
                       std::count(region[figure].begin(), region[figure].end(), Json()) > 0;
      if (there && !gap) continue;
      out.push_back(name);
      break;
    }
  }
  return out;
}

// The profiles of kernels.npz, [region][channel] on shared radii.
class TrueProfiles {
 public:
  explicit TrueProfiles(const fs::path& file) : r_(read_npz(file, "r")), all_(read_npz(file, "R")) {
    const bool fits = all_.shape.size() == 3 && all_.shape[1] == 3 &&
                      all_.shape[2] == r_.values.size() && r_.values.size() > 1;
    if (!fits)
      throw_bad_input(file.string(), "R is not regions x 3 x radii",
                      "take the truth of `lamella twin` again");
  }

  size_t regions() const { return all_.shape[0]; }

  TrueProfile at(size_t region, int channel) const {
    const size_t n = r_.values.size();
    const auto begin = all_.values.begin() + long((region * 3 + size_t(channel)) * n);
    return {r_.values, {begin, begin + long(n)}};
  }

 private:
  NpzArray r_, all_;
};

// Adds profile_L1 to every region of which the truth knows the profiles and the fit the albedos.
void add_profiles(ComparedMaps* maps, const v1::Layers& found, const v1::Layers& truth,
                  Json* regions) {
  const fs::path file = maps->truth_folder / "kernels.npz";
  if (!fs::exists(file)) return;
  const MapValues deep = maps->found("deep_albedo", {"R", "G", "B"});
  const MapValues shallow = maps->found("shallow_albedo", {"R", "G", "B"});
  if (deep.empty() || shallow.empty()) return;
  const TrueProfiles profiles(file);
  for (int i = 0; i < truth.regions_size() && size_t(i) < profiles.regions(); ++i) {
    const v1::Region* fitted = region_named(found, truth.regions(i).name());
    if (!fitted || fitted->deep().ld_mm_size() == 0) continue;
    const std::vector<double> d = region_medians(*maps, deep, i + 1);
    const std::vector<double> s = region_medians(*maps, shallow, i + 1);
    Json& list = (*regions)[fitted->name()]["profile_L1"];
    for (int c = 0; c < 3; ++c) {
      list.push_back(number(profile_L1(*fitted, c, d[c], s[c], profiles.at(size_t(i), c))));
    }
  }
}

Json g_figures(const v1::SingleGlobal& found, const v1::SingleGlobal& truth) {
  Json error = Json::array();
  for (int c = 0; c < std::min(found.g_size(), truth.g_size()); ++c) {
    error.push_back(number(std::abs(found.g(c) - truth.g(c))));
  }
  return {{"fit", list_of(found.g())}, {"truth", list_of(truth.g())}, {"abs_error", error}};
}

}  // namespace

void compare_layers(ComparedMaps* maps, const v1::Layers& truth, Json* figures) {
  const v1::Layers found = read_layers(maps->found_folder / "layers.json");
  Json regions = Json::object();
  for (const v1::Region& true_region : truth.regions()) {
    const v1::Region* same = region_named(found, true_region.name());
    if (!same) maps->problems.push_back("layers.json: no region " + true_region.name());
    regions[true_region.name()] = same ? region_figures(*same, true_region) : Json::object();
  }
  add_profiles(maps, found, truth, &regions);
  (*figures)["regions"] = regions;
  if (found.single().g_size() > 0) (*figures)["g"] = g_figures(found.single(), truth.single());
  (*figures)["timings_s"] = (*figures)["checks"] = nullptr;
  for (const auto& [name, value] : found.timings_s()) (*figures)["timings_s"][name] = value;
  for (const auto& [name, value] : found.checks()) (*figures)["checks"][name] = number(value);
  (*figures)["summary"] = {
      {"ld_mean_abs_rel_error", mean_over_regions(regions, "ld_rel_error")},
      {"single_amplitude_mean_abs_rel_error",
       mean_over_regions(regions, "single_amplitude_rel_error")},
      {"profile_L1_mean", mean_over_regions(regions, "profile_L1")},
      {"regions_without_a_figure", regions_without_a_figure(regions)},
      {"gaussian_m_mean_abs_error", mean_over_regions(regions, "gaussian_m_abs_error")},
      {"p_L1_mean", mean_over_regions(regions, "p_L1")}};
}

}  // namespace lamella::apps
