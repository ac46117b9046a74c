#include "apps/compare_maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "apps/compare_confidence.h"
#include "base/error.h"
#include "io/labels.h"

namespace lamella::apps {

namespace {

const std::vector<std::string> kXyz{"X", "Y", "Z"}, kRgb{"R", "G", "B"};
const std::vector<std::string> kNine{"r.X", "r.Y", "r.Z", "g.X", "g.Y", "g.Z", "b.X", "b.Y", "b.Z"};

struct MapKind {
  const char* name;
  const std::vector<std::string>& channels;
};

const std::vector<std::string> kY{"Y"};
const MapKind kMaps[] = {
    {"position", kXyz},         {"normal_specular", kXyz}, {"normal_diffuse", kNine},
    {"specular_intensity", kY}, {"single_albedo", kRgb},   {"shallow_albedo", kRgb},
    {"deep_albedo", kRgb},      {"deep_alpha", kRgb},      {"deep_ld", kRgb}};

MapValues at_labels(const std::vector<Image1>& planes, const Labels& regions) {
  MapValues values;
  for (const Image1& plane : planes) {
    std::vector<double>& channel = values.channels.emplace_back();
    for (int i = 0; i < regions.rows; ++i) {
      for (int j = 0; j < regions.cols; ++j) {
        if (regions(i, j)) channel.push_back(plane(i, j));
      }
    }
  }
  return values;
}

std::vector<double> angles(const MapValues& a, int first_a, const MapValues& b, int first_b) {
  std::vector<double> result(a.channels[0].size());
  for (size_t i = 0; i < result.size(); ++i) {
    result[i] = degrees_between(a.vector(i, first_a), b.vector(i, first_b));
  }
  return result;
}

std::vector<double> of_region(const ComparedMaps& maps, const std::vector<double>& values,
                              int label) {
  std::vector<double> kept;
  for (size_t i = 0; i < values.size(); ++i) {
    if (maps.label[i] == label) kept.push_back(values[i]);
  }
  return kept;
}

Json ratios(const MapValues& found, const MapValues& truth) {
  Json list = Json::array();
  for (size_t c = 0; c < found.channels.size(); ++c) {
    list.push_back(ratio_statistics(found.channels[c], truth.channels[c]));
  }
  return list;
}

Json position_figures(const MapValues& found, const MapValues& truth) {
  std::vector<double> error;
  std::vector<Vec3d> from, to;
  for (size_t i = 0; i < found.channels[0].size(); ++i) {
    if (!found.known(i) || !truth.known(i)) continue;
    from.emplace_back(found.vector(i));
    to.emplace_back(truth.vector(i));
    error.push_back(cv::norm(from.back() - to.back()));
  }
  if (error.empty()) return nullptr;
  size_t near = 0;
  for (double e : error) near += e < 1;
  Json out{{"error_mm", error_statistics(error)},
           {"within_1mm", double(near) / double(error.size())}};
  if (error.size() <= 100) return out;
  const double limit = percentile(error, 0.99);
  double squares = 0;
  size_t count = 0;
  for (double e : error) {
    if (e <= limit) squares += e * e, ++count;
  }
  out["rms_trimmed99_mm"] = std::sqrt(squares / double(count));
  const RigidMotion motion = robust_rigid_motion(from, to);
  for (size_t i = 0; i < error.size(); ++i) error[i] = cv::norm(motion(from[i]) - to[i]);
  out["after_rigid_mm"] = error_statistics(error);
  out["rigid"] = {{"rotation_deg", motion.degrees()},
                  {"translation_mm", {motion.shift[0], motion.shift[1], motion.shift[2]}}};
  return out;
}

Json normal_figures(const ComparedMaps& maps, const MapValues& found, const MapValues& truth) {
  const std::vector<double> error = angles(found, 0, truth, 0);
  size_t known = 0, not_unit = 0;
  for (size_t i = 0; i < error.size(); ++i) {
    if (!found.known(i)) continue;
    ++known;
    not_unit += std::abs(length(found.vector(i)) - 1) > 0.01;
  }
  Json regions = Json::object();
  for (size_t r = 0; r < maps.region_names.size(); ++r) {
    const Json s = error_statistics(of_region(maps, error, int(r) + 1));
    regions[maps.region_names[r]] = s.is_null() ? Json() : s["median"];
  }
  return {{"deg", error_statistics(error)},
          {"not_unit", number(double(not_unit) / double(known))},
          {"per_region", regions}};
}

Json diffuse_normal_figures(const MapValues& found, const MapValues& truth,
                            const MapValues& surface) {
  Json out = Json::object();
  for (int c = 0; c < 3; ++c) {
    out[std::string(1, "rgb"[c])] = {
        {"deg", error_statistics(angles(found, 3 * c, truth, 3 * c))},
        {"deg_to_surface", error_statistics(angles(found, 3 * c, surface, 0))}};
  }
  return out;
}

Json intensity_figures(const ComparedMaps& maps, const MapValues& found, const MapValues& truth) {
  Json regions = Json::object();
  for (size_t r = 0; r < maps.region_names.size(); ++r) {
    regions[maps.region_names[r]] =
        ratio_statistics(of_region(maps, found.channels[0], int(r) + 1),
                         of_region(maps, truth.channels[0], int(r) + 1));
  }
  return {{"all", ratio_statistics(found.channels[0], truth.channels[0])}, {"per_region", regions}};
}

Json absolute_errors(const MapValues& found, const MapValues& truth) {
  Json list = Json::array();
  for (size_t c = 0; c < found.channels.size(); ++c) {
    std::vector<double> error(found.channels[c].size());
    for (size_t i = 0; i < error.size(); ++i) {
      error[i] = std::abs(found.channels[c][i] - truth.channels[c][i]);
    }
    list.push_back(error_statistics(error));
  }
  return list;
}

Json ld_map_figures(const ComparedMaps& maps, const MapValues& found, const MapValues& truth) {
  MapValues ratio = found;
  for (size_t c = 0; c < 3; ++c) {
    for (size_t i = 0; i < ratio.channels[c].size(); ++i) {
      ratio.channels[c][i] /= truth.channels[c][i];
    }
  }
  Json out = Json::object();
  for (size_t r = 0; r < maps.region_names.size(); ++r) {
    for (double m : region_medians(maps, ratio, int(r) + 1)) {
      out[maps.region_names[r]].push_back(number(m - 1));
    }
  }
  return out;
}

}  // namespace

bool MapValues::known(size_t pixel) const {
  for (const auto& channel : channels) {
    if (!std::isfinite(channel[pixel])) return false;
  }
  return true;
}

Vec3 MapValues::vector(size_t pixel, int first) const {
  return {float(channels[first][pixel]), float(channels[first + 1][pixel]),
          float(channels[first + 2][pixel])};
}

MapValues ComparedMaps::found(const std::string& name, const std::vector<std::string>& channels) {
  const fs::path file = found_folder / (name + ".exr");
  if (!fs::exists(file)) {
    problems.push_back("missing " + name + ".exr");
    return {};
  }
  const std::vector<std::string> has = exr_channels(file);
  for (const std::string& channel : channels) {
    if (std::find(has.begin(), has.end(), channel) != has.end()) continue;
    problems.push_back(name + ".exr has no channel " + channel);
    return {};
  }
  const std::vector<Image1> planes = read_exr(file, channels);
  if (planes[0].size() == regions.size()) return at_labels(planes, regions);
  problems.push_back(name + ".exr is " + size_words(planes[0].size()) + ", expected " +
                     size_words(regions.size()));
  return {};
}

MapValues ComparedMaps::truth(const std::string& name, const std::vector<std::string>& channels) {
  const fs::path file = truth_folder / (name + ".exr");
  const std::vector<Image1> planes = read_exr(file, channels);
  if (planes[0].size() != regions.size()) {
    throw_bad_input(file.string(), "is not of the size of regions.png",
                    "take both of the same truth");
  }
  return at_labels(planes, regions);
}

bool ComparedMaps::has_truth(const std::string& name) const {
  return fs::exists(truth_folder / (name + ".exr"));
}

ComparedMaps open_maps(const fs::path& found_folder, const fs::path& truth_folder,
                       const std::vector<std::string>& region_names) {
  ComparedMaps maps;
  maps.found_folder = found_folder;
  maps.truth_folder = truth_folder;
  maps.region_names = region_names;
  const fs::path labels = truth_folder / "regions.png";
  if (!fs::exists(labels)) {
    throw_bad_input(labels.string(), "cannot be read", "the second folder must hold the truth");
  }
  maps.regions = read_labels(labels);
  for (uchar label : maps.regions) {
    if (label) maps.label.push_back(label);
  }
  if (maps.label.empty()) {
    throw_bad_input(labels.string(), "no pixel is labelled", "give the truth's own label image");
  }
  return maps;
}

std::vector<double> region_medians(const ComparedMaps& maps, const MapValues& map, int label) {
  std::vector<double> medians;
  for (const auto& channel : map.channels) {
    medians.push_back(median(finite(of_region(maps, channel, label))));
  }
  return medians;
}

namespace {

using Table = std::map<std::string, MapValues>;

constexpr double kLeastAnswered = 0.97;  // as the session format asks

void add_coverage_of(const std::string& name, const Table& found, const Table& truth,
                     ComparedMaps* maps, Json* figures) {
  const MapValues& f = found.at(name);
  if (f.empty()) {
    (*figures)["coverage"][name] = nullptr;
    return;
  }
  const auto t = truth.find(name);
  size_t known = 0, asked = 0, answered = 0, infinite = 0;
  for (size_t i = 0; i < f.channels[0].size(); ++i) {
    known += f.known(i);
    for (const auto& channel : f.channels) infinite += std::isinf(channel[i]);
    if (t == truth.end() || !t->second.known(i)) continue;
    ++asked;
    answered += f.known(i);
  }
  (*figures)["coverage"][name] = double(known) / double(f.channels[0].size());
  (*figures)["answered"][name] = number(double(answered) / double(asked));
  if (double(answered) < kLeastAnswered * double(asked)) {
    maps->problems.push_back(
        fmt::format("{}.exr answers {:.1f} % of the labelled pixels, at least {:g} % asked", name,
                    100 * double(answered) / double(asked), 100 * kLeastAnswered));
  }
  if (infinite) (*figures)["infinite"][name] = infinite;
}

void add_coverage(const Table& found, const Table& truth, ComparedMaps* maps, Json* figures) {
  (*figures)["infinite"] = Json::object();
  for (const MapKind& kind : kMaps) add_coverage_of(kind.name, found, truth, maps, figures);
}

void add_albedos(ComparedMaps* maps, Table* found, Table* truth, Json* figures) {
  for (const char* name : {"single_albedo", "shallow_albedo", "deep_albedo", "deep_alpha"}) {
    const MapValues& f = (*found)[name];
    if (f.empty() || !truth->count(name)) continue;
    (*figures)[name]["error"] = ratios(f, (*truth)[name]);
    const std::string physical = std::string(name) + "_physical";
    if (maps->has_truth(physical)) {
      (*figures)[name]["against_physical_layer"] = ratios(f, maps->truth(physical, kRgb));
    }
  }
  if (figures->contains("deep_alpha")) {
    (*figures)["deep_alpha"]["abs_error"] =
        absolute_errors((*found)["deep_alpha"], (*truth)["deep_alpha"]);
  }
  MapValues sum = (*found)["shallow_albedo"];
  const MapValues& deep = (*found)["deep_albedo"];
  if (sum.empty() || deep.empty() || !maps->has_truth("total_albedo")) return;
  for (size_t c = 0; c < 3; ++c) {
    for (size_t i = 0; i < sum.channels[c].size(); ++i) sum.channels[c][i] += deep.channels[c][i];
  }
  (*figures)["closure_vs_total_albedo"] = ratios(sum, maps->truth("total_albedo", kRgb));
}

std::vector<std::string> channels_of(const fs::path& file, ComparedMaps* maps) {
  try {
    return exr_channels(file);
  } catch (const Error& e) {
    maps->problems.push_back(e.what());
    return {};
  }
}

void note_bad_confidence(const std::string& name, const std::vector<double>& confidence,
                         ComparedMaps* maps) {
  const bool is_bad =
      std::any_of(confidence.begin(), confidence.end(), [](double v) { return v < 0 || v > 1; });
  if (is_bad) maps->problems.push_back("confidence " + name + " outside 0..1");
}

void add_confidence(ComparedMaps* maps, Table* found, Table* truth, Json* figures) {
  const fs::path file = maps->found_folder / "confidence.exr";
  if (!fs::exists(file)) {
    maps->problems.push_back("missing confidence.exr");
    return;
  }
  const auto errors_of = [&](const std::string& name) {
    for (const auto& [map, values] : *found) {
      if (!name.starts_with(map) || values.empty() || !truth->count(map)) continue;
      return pixel_errors(map, values, (*truth)[map]);
    }
    return PixelErrors();
  };
  for (const std::string& name : channels_of(file, maps)) {
    const MapValues map = maps->found("confidence", {name});
    if (map.empty()) continue;
    note_bad_confidence(name, map.channels[0], maps);
    (*figures)["confidence"][name] = confidence_figures(map.channels[0], errors_of(name));
  }
}

}  // namespace

void compare_maps(ComparedMaps* maps, Json* figures) {
  Table found, truth;
  for (const MapKind& kind : kMaps) {
    found[kind.name] = maps->found(kind.name, kind.channels);
    if (maps->has_truth(kind.name)) truth[kind.name] = maps->truth(kind.name, kind.channels);
  }
  const auto both = [&](const char* name) { return !found[name].empty() && truth.count(name); };
  (*figures)["labelled_pixels"] = maps->label.size();
  add_coverage(found, truth, maps, figures);
  if (both("position")) {
    (*figures)["position"] = position_figures(found["position"], truth["position"]);
  }
  if (both("normal_specular")) {
    (*figures)["normal_specular"] =
        normal_figures(*maps, found["normal_specular"], truth["normal_specular"]);
  }
  if (both("normal_diffuse") && truth.count("normal_specular")) {
    (*figures)["normal_diffuse"] = diffuse_normal_figures(
        found["normal_diffuse"], truth["normal_diffuse"], truth["normal_specular"]);
  }
  if (both("specular_intensity")) {
    (*figures)["specular_intensity"] =
        intensity_figures(*maps, found["specular_intensity"], truth["specular_intensity"]);
  }
  add_albedos(maps, &found, &truth, figures);
  if (both("deep_ld")) {
    (*figures)["deep_ld_map"] = ld_map_figures(*maps, found["deep_ld"], truth["deep_ld"]);
  }
  // Left out by fits that stop before it.
  if (fs::exists(maps->found_folder / "total_albedo.exr") && maps->has_truth("total_albedo")) {
    found["total_albedo"] = maps->found("total_albedo", kRgb);
    truth["total_albedo"] = maps->truth("total_albedo", kRgb);
  }
  if (both("total_albedo")) {
    add_coverage_of("total_albedo", found, truth, maps, figures);
    (*figures)["total_albedo"]["error"] = ratios(found["total_albedo"], truth["total_albedo"]);
  }
  add_confidence(maps, &found, &truth, figures);
}

}  // namespace lamella::apps
