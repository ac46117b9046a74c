#include "io/layer_maps.h"

#include <bit>
#include <cmath>
#include <functional>

#include "base/error.h"
#include "base/parallel.h"
#include "io/json.h"
#include "io/labels.h"
#include "io/whole_file.h"

namespace lamella {

namespace {

// Name of the file, the member, whether its channels are X Y Z (else R G B), and how it is stored.
// A half resolves one part in 2000, below any map's own error; only a position needs more. Its last
// digits are noise, which ZIP packs little better than run lengths do.
struct Map3 {
  const char* name;
  Image3 LayerMaps::*member;
  bool xyz;
  PixelType type;
};

constexpr Map3 kMaps3[] = {
    {"position", &LayerMaps::position_mm, true, PixelType::kFloat},
    {"normal_specular", &LayerMaps::normal_specular, true, PixelType::kHalfInRuns},
    {"single_albedo", &LayerMaps::single_albedo, false, PixelType::kHalfInRuns},
    {"total_albedo", &LayerMaps::total_albedo, false, PixelType::kHalfInRuns},
    {"shallow_albedo", &LayerMaps::shallow_albedo, false, PixelType::kHalfInRuns},
    {"deep_albedo", &LayerMaps::deep_albedo, false, PixelType::kHalfInRuns},
    {"deep_alpha", &LayerMaps::deep_alpha, false, PixelType::kHalfInRuns},
    {"deep_ld", &LayerMaps::deep_ld_mm, false, PixelType::kHalfInRuns},
};

std::vector<std::string> diffuse_channels() {
  std::vector<std::string> names;
  for (const char* c : {"r", "g", "b"}) {
    for (const char* a : {"X", "Y", "Z"}) names.push_back(std::string(c) + "." + a);
  }
  return names;
}

void read_normal_diffuse(const fs::path& file, LayerMaps* maps) {
  const std::vector<Image1> planes = read_exr(file, diffuse_channels());
  for (int c = 0; c < 3; ++c) {
    const std::vector<cv::Mat> xyz(planes.begin() + 3 * c, planes.begin() + 3 * c + 3);
    cv::merge(xyz, maps->normal_diffuse[c]);
  }
}

// What the whole image has where the maps have no pixel.
std::optional<ExrSurroundings> around(const LayerMaps& maps, float value = kNaN) {
  if (!maps.window) return std::nullopt;
  return ExrSurroundings{*maps.window, value};
}

void write_normal_diffuse(const fs::path& file, const LayerMaps& maps) {
  const std::vector<std::string> names = diffuse_channels();
  std::vector<std::pair<std::string, Image1>> channels;
  for (int c = 0; c < 3; ++c) {
    std::vector<cv::Mat> xyz;
    cv::split(maps.normal_diffuse[c], xyz);
    for (int a = 0; a < 3; ++a) channels.emplace_back(names[3 * c + a], xyz[a]);
  }
  write_exr(file, channels, PixelType::kHalfInRuns, around(maps));
}

// Digits that mean nothing cost time to compress and room on the disk.
constexpr float kPositionStep_mm = 1.f / 1024;
constexpr float kConfidenceStep = 1.f / 256;

void round_to(float step, cv::Mat values) {
  float* const first = values.ptr<float>();
  const size_t count = values.total() * size_t(values.channels());
  for (size_t i = 0; i < count; ++i) first[i] = std::round(first[i] / step) * step;
}

Image3 rounded_position(const Image3& position_mm) {
  Image3 rounded = position_mm.clone();
  round_to(kPositionStep_mm, rounded);
  return rounded;
}

void write_confidence(const fs::path& file, const LayerMaps& maps) {
  std::vector<std::pair<std::string, Image1>> channels;
  for (const auto& [name, plane] : maps.confidence) {
    channels.emplace_back(name, plane.clone());
    round_to(kConfidenceStep, channels.back().second);
  }
  write_exr(file, channels, PixelType::kHalf, around(maps, 0));
}

// To 3 %: what a deviation is known to, by far.
float rounded_deviation(float value) {
  constexpr uint32_t kDropped = 18;  // of a float's 23 bits
  const uint32_t bits = std::bit_cast<uint32_t>(value) + (1u << (kDropped - 1));
  return std::isfinite(value) ? std::bit_cast<float>(bits >> kDropped << kDropped) : value;
}

void write_stddev(const fs::path& file, const LayerMaps& maps) {
  std::vector<std::pair<std::string, Image1>> channels;
  for (const auto& [name, plane] : maps.stddev) {
    channels.emplace_back(name, plane.clone());
    for (float& value : channels.back().second) value = rounded_deviation(value);
  }
  write_exr(file, channels, PixelType::kHalf, around(maps));
}

void write_regions(const fs::path& file, const LayerMaps& maps) {
  if (!maps.window) return write_labels(file, maps.regions);
  Labels whole(maps.window->whole, 0);
  maps.regions.copyTo(whole(maps.window->area));
  write_labels(file, whole);
}

// Every map shows the same pixels.
void require_one_size(const fs::path& folder, const LayerMaps& maps) {
  const auto require = [&](const std::string& file, cv::Size size) {
    if (size.empty() || size == maps.position_mm.size()) return;
    throw_bad_input(
        (folder / file).string(),
        size_words(size) + " pixels, position.exr has " + size_words(maps.position_mm.size()),
        "run fit again");
  };
  for (const Map3& m : kMaps3) require(std::string(m.name) + ".exr", (maps.*m.member).size());
  require("normal_diffuse.exr", maps.normal_diffuse[0].size());
  require("specular_intensity.exr", maps.specular_intensity.size());
  require("regions.png", maps.regions.size());
  for (const auto& [name, plane] : maps.confidence) require("confidence.exr", plane.size());
}

}  // namespace

std::vector<fs::path> files_of_layers(const fs::path& folder) {
  std::vector<fs::path> files{folder / "layers.json", folder / "regions.png"};
  for (const Map3& m : kMaps3) files.push_back(folder / (std::string(m.name) + ".exr"));
  for (const char* name : {"normal_diffuse.exr", "specular_intensity.exr", "confidence.exr"}) {
    files.push_back(folder / name);
  }
  return files;
}

std::vector<std::pair<std::string, cv::Mat>> named_maps(const LayerMaps& maps) {
  std::vector<std::pair<std::string, cv::Mat>> named{
      {"specular_intensity", maps.specular_intensity}};
  for (const Map3& map : kMaps3) named.emplace_back(map.name, maps.*map.member);
  for (const Image3& normal : maps.normal_diffuse) named.emplace_back("normal_diffuse", normal);
  return named;
}

LayerMaps part_of(const LayerMaps& maps, const cv::Rect& area) {
  LayerMaps part = maps;
  const auto cut = [&](auto& map) {
    if (!map.empty()) map = map(area);
  };
  for (const Map3& m : kMaps3) cut(part.*m.member);
  for (Image3& normal : part.normal_diffuse) cut(normal);
  cut(part.specular_intensity);
  cut(part.regions);
  for (auto& [name, map] : part.confidence) cut(map);
  for (auto& [name, map] : part.stddev) cut(map);
  return part;
}

LayerMaps read_layer_maps(const fs::path& folder) {
  if (!fs::is_directory(folder))
    throw_bad_input(folder.string(), "no such folder", "run `lamella fit` first");
  LayerMaps maps;
  const auto at = [&](const std::string& name) { return folder / (name + ".exr"); };
  for (const Map3& m : kMaps3) {
    if (!fs::exists(at(m.name))) continue;
    maps.*m.member = m.xyz ? read_exr_xyz(at(m.name)) : read_exr_rgb(at(m.name));
  }
  for (const char* needed : {"position", "normal_specular"}) {
    if (fs::exists(at(needed))) continue;
    throw_bad_input(at(needed).string(), "missing", "run fit to its end");
  }
  if (fs::exists(at("normal_diffuse"))) read_normal_diffuse(at("normal_diffuse"), &maps);
  if (fs::exists(at("specular_intensity"))) {
    maps.specular_intensity = read_exr(at("specular_intensity"), {"Y"})[0];
  }
  if (fs::exists(at("confidence"))) {
    const std::vector<std::string> names = exr_channels(at("confidence"));
    const std::vector<Image1> planes = read_exr(at("confidence"), names);
    for (size_t i = 0; i < names.size(); ++i) maps.confidence[names[i]] = planes[i];
  }
  maps.regions = read_labels(folder / "regions.png");
  require_one_size(folder, maps);
  return maps;
}

void write_layer_maps(const fs::path& folder, const LayerMaps& maps) {
  std::vector<std::function<void()>> jobs;
  const auto at = [&](const std::string& name) { return folder / (name + ".exr"); };
  if (!maps.normal_diffuse[0].empty()) {
    jobs.push_back([&] { write_normal_diffuse(at("normal_diffuse"), maps); });
  }
  if (!maps.confidence.empty()) {
    jobs.push_back([&] { write_confidence(at("confidence"), maps); });
  }
  if (!maps.stddev.empty()) jobs.push_back([&] { write_stddev(at("stddev"), maps); });
  for (const Map3& m : kMaps3) {
    if ((maps.*m.member).empty()) continue;
    jobs.push_back([&maps, &m, at] {
      if (m.xyz) {
        const bool is_position = m.member == &LayerMaps::position_mm;
        write_exr_xyz(at(m.name), is_position ? rounded_position(maps.position_mm) : maps.*m.member,
                      m.type, around(maps));
      } else {
        write_exr_rgb(at(m.name), maps.*m.member, m.type, around(maps));
      }
    });
  }
  if (!maps.specular_intensity.empty()) {
    jobs.push_back([&] {
      write_exr(at("specular_intensity"), {{"Y", maps.specular_intensity}}, PixelType::kHalfInRuns,
                around(maps));
    });
  }
  jobs.push_back([&] { write_regions(folder / "regions.png", maps); });
  parallel_for(int(jobs.size()), [&](int i) { jobs[size_t(i)](); });
}

v1::Layers read_layers(const fs::path& file) {
  v1::Layers layers;
  read_json(file, &layers, NonFinite::kAllowed);
  if (layers.format() != "lamella.layers.v1") {
    throw_bad_input(file.string() + ": format", "\"" + layers.format() + "\"",
                    "this program reads lamella.layers.v1; run fit again");
  }
  if (layers.regions_size() == 0) {
    throw_bad_input(file.string() + ": regions", "missing", "run fit again");
  }
  return layers;
}

}  // namespace lamella
