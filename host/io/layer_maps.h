// The maps that `fit` writes and `truth/` holds, in left-camera pixels; NaN means not known.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>

#include "io/exr.h"
#include "layers.pb.h"

namespace lamella {

struct LayerMaps {
  Image3 position_mm;                    // rig frame
  Image3 normal_specular;                // unit, rig frame
  std::array<Image3, 3> normal_diffuse;  // per channel r, g, b
  Image1 specular_intensity;             // c of eq. 1
  Image3 single_albedo;
  Image3 total_albedo;
  Image3 shallow_albedo;
  Image3 deep_albedo;
  Image3 deep_alpha;
  Image3 deep_ld_mm;
  std::map<std::string, Image1> confidence;  // by map name, 0 to 1; empty in truth/
  // What the camera's noise does to a map, and what was averaged away with it, one sigma, in its
  // unit: "deep_albedo.R". Of the fit; not read back.
  std::map<std::string, Image1> stddev;
  Labels regions;
  // Of the left camera's pixels, those that the maps have; nothing is known of others. Of a fit;
  // without it they have all.
  std::optional<PixelWindow> window;
};

// Each map by the name of its file, empty ones too; `normal_diffuse` thrice, a channel each.
std::vector<std::pair<std::string, cv::Mat>> named_maps(const LayerMaps& maps);

// What lies in `area` of every map; the pixels are shared.
LayerMaps part_of(const LayerMaps& maps, const cv::Rect& area);

// Reads a folder of maps. A map that is not there stays empty; `position`, `normal_specular` and
// `regions.png` must be there. Throws Error.
LayerMaps read_layer_maps(const fs::path& folder);

// Every file that may be read of such a folder, be it there or not.
std::vector<fs::path> files_of_layers(const fs::path& folder);

// Writes all maps that are not empty, in parallel, and regions.png, all at the size of the camera.
// Channel names as documented.
void write_layer_maps(const fs::path& folder, const LayerMaps& maps);

v1::Layers read_layers(const fs::path& file);  // layers.json

}  // namespace lamella
