// The maps of a fit against those of the truth, pixel by pixel over the labelled ones.
#pragma once

#include <string>
#include <vector>

#include "apps/compare_statistics.h"
#include "io/exr.h"

namespace lamella::apps {

// A map at the labelled pixels.
struct MapValues {
  std::vector<std::vector<double>> channels;  // channel by channel

  bool empty() const { return channels.empty(); }
  bool known(size_t pixel) const;  // every channel finite
  Vec3 vector(size_t pixel, int first = 0) const;
};

struct ComparedMaps {
  fs::path found_folder, truth_folder;
  Labels regions;                         // the truth's
  std::vector<int> label;                 // of each labelled pixel
  std::vector<std::string> region_names;  // by label - 1
  std::vector<std::string> problems;

  // The found map `name`; empty, with a problem noted, where it is missing or of another size.
  MapValues found(const std::string& name, const std::vector<std::string>& channels);
  MapValues truth(const std::string& name, const std::vector<std::string>& channels);
  bool has_truth(const std::string& name) const;
};

ComparedMaps open_maps(const fs::path& found_folder, const fs::path& truth_folder,
                       const std::vector<std::string>& region_names);

// Adds every figure of the maps to `figures`: coverage, answered, position, normals, albedos,
// confidence. The names are those of the project's judge.
void compare_maps(ComparedMaps* maps, Json* figures);

// Median of the found map over a region's pixels, per channel; what a profile is scaled to.
std::vector<double> region_medians(const ComparedMaps& maps, const MapValues& map, int label);

}  // namespace lamella::apps
