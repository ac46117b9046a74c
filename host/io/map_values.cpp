#include "io/map_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/error.h"
#include "base/parallel.h"

namespace lamella {

namespace {

// Of its channels. Wide: noise where hardly any light falls goes beyond what a surface reflects.
struct Range {
  const char* map;
  float least, most;
  const char* words;
};

constexpr float kFarthest_mm = 1e5f, kLongest_mm = 1e3f, kMostIntensity = 1e3f;
constexpr float kLeastReflectance = -1, kMostReflectance = 4;
constexpr const char* kReflectance = "a reflectance is -1 to 4";
constexpr Range kRanges[] = {
    {"position", -kFarthest_mm, kFarthest_mm, "a position is within 100 m"},
    {"specular_intensity", -1, kMostIntensity, "c is 0 to 1000"},
    {"single_albedo", kLeastReflectance, kMostReflectance, kReflectance},
    {"total_albedo", kLeastReflectance, kMostReflectance, kReflectance},
    {"shallow_albedo", kLeastReflectance, kMostReflectance, kReflectance},
    {"deep_albedo", kLeastReflectance, kMostReflectance, kReflectance},
    {"deep_alpha", 0, 1, "a scattering albedo is 0 to 1"},
    {"deep_ld", 0, kLongest_mm, "l_d is 0 to 1000 mm"},
};
constexpr float kMostLengthOff = 0.05f;  // of a normal; halves leave 0.0005

// Null: of a normal.
const Range* range_of(const std::string& map) {
  const auto* range = std::find_if(std::begin(kRanges), std::end(kRanges),
                                   [&](const Range& r) { return map == r.map; });
  return range == std::end(kRanges) ? nullptr : range;
}

struct Pixels {
  const cv::Mat& map;
  const Range* range;        // null: of a normal
  const Image1* confidence;  // null: none is given
};

std::string problem_of_normal(const float* n) {
  const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (std::abs(length - 1) <= kMostLengthOff) return "";
  return fmt::format("a normal of length {:.3g}", length);
}

// Of one pixel; empty where it has none.
std::string problem_at(const Pixels& pixels, int y, int x) {
  const int channels = pixels.map.channels();
  const float* value = pixels.map.ptr<float>(y) + x * channels;
  if (std::any_of(value, value + channels, [](float v) { return std::isnan(v); })) {
    const bool is_sure = pixels.confidence && (*pixels.confidence)(y, x) > 0;
    return is_sure ? "no number where confidence.exr is above 0" : "";
  }
  if (!pixels.range) return problem_of_normal(value);
  for (int c = 0; c < channels; ++c) {
    if (value[c] >= pixels.range->least && value[c] <= pixels.range->most) continue;
    return fmt::format("{:.4g}, and {}", value[c], pixels.range->words);
  }
  return "";
}

// The first, by rows.
std::string problem_of(const Pixels& pixels) {
  std::vector<std::string> rows(size_t(pixels.map.rows));
  parallel_for(pixels.map.rows, [&](int y) {
    for (int x = 0; x < pixels.map.cols; ++x) {
      const std::string problem = problem_at(pixels, y, x);
      if (problem.empty()) continue;
      rows[size_t(y)] = fmt::format("has, at pixel ({}, {}), {}", x, y, problem);
      return;
    }
  });
  const auto first =
      std::find_if(rows.begin(), rows.end(), [](const auto& row) { return !row.empty(); });
  return first == rows.end() ? "" : *first;
}

}  // namespace

void require_possible_values(const fs::path& folder, const LayerMaps& maps) {
  for (const auto& [name, map] : named_maps(maps)) {
    const auto confidence = maps.confidence.find(name);
    const std::string problem = problem_of(
        {map, range_of(name), confidence == maps.confidence.end() ? nullptr : &confidence->second});
    if (!problem.empty())
      throw_bad_input((folder / (name + ".exr")).string(), problem, "fit again");
  }
}

}  // namespace lamella
