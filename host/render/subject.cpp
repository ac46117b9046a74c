#include "render/subject.h"

#include "base/error.h"
#include "io/fit_folder.h"

namespace lamella::render {

namespace {

void require_size(const Image3& map, const Camera& camera, const std::string& where) {
  const cv::Size size(camera.width, camera.height);
  if (map.size() == size) return;
  throw_bad_input(where,
                  size_words(map.size()) + " pixels, the left camera has " + size_words(size),
                  "fit this session again");
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
  FitFolder fit = read_fit_folder(fit_folder);
  // The maps are of one size, which need not be this session's.
  require_size(fit.maps.position_mm, subject.left, (fit_folder / "position.exr").string());
  subject.region_names = {"background"};
  for (const v1::Region& region : fit.layers.regions()) {
    subject.region_names.push_back(region.name());
  }
  subject.maps = std::move(fit.maps);
  subject.layers = std::move(fit.layers);
  return subject;
}

}  // namespace lamella::render
