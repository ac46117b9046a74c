#include "apps/compare_folders.h"

#include <algorithm>

#include "apps/compare_images.h"
#include "apps/compare_layers.h"
#include "base/error.h"

namespace lamella::apps {

namespace {

Mask complement(const Mask& mask) { return ~mask; }

// Errors over the surface that the left camera saw, and over the rest.
void add_seen(const Image3& found, const Image3& truth, const Mask& subject, const Mask& seen,
              Json* figures) {
  const double all = cv::countNonZero(subject);
  const std::pair<const char*, Mask> parts[] = {{"seen", subject & seen},
                                                {"unseen", subject & complement(seen)}};
  for (const auto& [name, part] : parts) {
    if (cv::countNonZero(part) == 0) continue;
    (*figures)[std::string("rel_rmse_") + name] = number(relative_rmse(found, truth, part));
    (*figures)[std::string("share_") + name] = cv::countNonZero(part) / all;
  }
}

// None where `maps` has a problem more.
Json view_figures(const fs::path& found_file, const fs::path& truth_stem, ComparedMaps* maps) {
  const Image3 truth = read_exr_rgb(truth_stem.string() + ".exr");
  const Image3 found = read_exr_rgb(found_file);
  if (found.size() != truth.size()) {
    maps->problems.push_back(found_file.string() + ": " + size_words(found.size()) +
                             " pixels, expected " + size_words(truth.size()));
    return {};
  }
  const Mask subject = read_mask(truth_stem.string() + "_mask.png", truth.size());
  const fs::path seen = truth_stem.string() + "_mask_seen.png";
  Json figures = Json::object();
  if (fs::exists(seen)) {
    add_seen(found, truth, subject, read_mask(seen, truth.size()), &figures);
  }
  figures.update(image_figures(found, truth, subject));
  return figures;
}

// Every picture in truth/views that the fit has rendered too.
void compare_views(ComparedMaps* maps, Json* figures) {
  Json& views = (*figures)["views"] = Json::object();
  const fs::path folder = maps->truth_folder / "views";
  if (!fs::is_directory(folder)) return;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".exr") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    const fs::path mine = maps->found_folder / "views" / file.filename();
    if (!fs::exists(mine)) continue;
    const Json view = view_figures(mine, folder / file.stem(), maps);
    if (!view.is_null()) views[file.stem().string()] = view;
  }
}

// What several figures miss is missing once.
std::vector<std::string> each_once(const std::vector<std::string>& problems) {
  std::vector<std::string> once;
  for (const std::string& problem : problems) {
    if (std::find(once.begin(), once.end(), problem) == once.end()) once.push_back(problem);
  }
  return once;
}

}  // namespace

Json compare_folders(const fs::path& found, const fs::path& truth) {
  if (!fs::exists(found / "layers.json")) {
    throw_bad_input(found.string(), "holds no layers.json, so it is no fit",
                    "give the folder that fit wrote");
  }
  const v1::Layers layers = read_layers(truth / "layers.json");
  std::vector<std::string> names;
  for (const v1::Region& region : layers.regions()) names.push_back(region.name());
  ComparedMaps maps = open_maps(found, truth, names);
  Json figures{{"fit", found.string()}, {"truth", truth.string()}, {"problems", Json::array()}};
  compare_maps(&maps, &figures);
  for (const char* file : {"regions.png", "total_albedo.exr", "model.glb"}) {
    if (!fs::exists(found / file)) maps.problems.push_back(std::string("missing ") + file);
  }
  compare_layers(&maps, layers, &figures);
  compare_views(&maps, &figures);
  figures["problems"] = each_once(maps.problems);
  return figures;
}

}  // namespace lamella::apps
