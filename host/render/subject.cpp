#include "render/subject.h"

#include "base/error.h"

namespace lamella::render {

namespace {

void require_size(const cv::Mat& map, const Camera& camera, const std::string& where) {
  if (map.empty() || (map.cols == camera.width && map.rows == camera.height)) return;
  throw_bad_input(where, "is " + std::to_string(map.cols) + "x" + std::to_string(map.rows) +
                             ", the left camera " + std::to_string(camera.width) + "x" +
                             std::to_string(camera.height));
}

void require_sizes(const Subject& subject, const std::string& folder) {
  const LayerMaps& m = subject.maps;
  const std::pair<const cv::Mat*, const char*> maps[] = {
      {&m.position_mm, "position.exr"},
      {&m.normal_specular, "normal_specular.exr"},
      {&m.regions, "regions.png"},
      {&m.specular_intensity, "specular_intensity.exr"},
      {&m.single_albedo, "single_albedo.exr"},
      {&m.total_albedo, "total_albedo.exr"},
      {&m.shallow_albedo, "shallow_albedo.exr"},
      {&m.deep_albedo, "deep_albedo.exr"},
      {&m.deep_ld_mm, "deep_ld.exr"}};
  for (const auto& [map, name] : maps) {
    require_size(*map, subject.left, folder + "/" + name);
  }
}

}  // namespace

const v1::Region* Subject::region(int label) const {
  if (label <= 0 || label >= int(region_names.size())) return nullptr;
  for (const v1::Region& region : layers.regions()) {
    if (region.name() == region_names[label]) return &region;
  }
  return nullptr;
}

Subject load_subject(const fs::path& session_folder, const fs::path& fit_folder) {
  const Session session = read_session(session_folder);
  Subject subject;
  subject.stage = session.stage;
  subject.left = session.left;
  subject.projector = session.projector;
  subject.maps = read_layer_maps(fit_folder);
  require_sizes(subject, fit_folder.string());
  if (subject.maps.deep_albedo.empty() || subject.maps.shallow_albedo.empty()) {
    throw_bad_input(fit_folder.string(), "no deep_albedo.exr or shallow_albedo.exr",
                    "run fit to its end");
  }
  subject.layers = read_layers(fit_folder / "layers.json");
  subject.region_names = session.region_names;
  return subject;
}

}  // namespace lamella::render
