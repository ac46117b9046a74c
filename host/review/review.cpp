#include "review/review.h"

#include <sstream>

#include "base/error.h"
#include "io/picture_png.h"
#include "io/whole_file.h"
#include "review/sheet.h"

namespace lamella::review {

LayerGains gains_named(const std::string& names) {
  LayerGains gains{0, 0, 0, 0};
  std::istringstream list(names);
  for (std::string name; std::getline(list, name, ',');) {
    if (name == "specular") {
      gains.specular = 1;
    } else if (name == "single") {
      gains.single = 1;
    } else if (name == "shallow") {
      gains.shallow = 1;
    } else if (name == "deep") {
      gains.deep = 1;
    } else if (name != "none") {
      throw_bad_input("--layers", "\"" + name + "\" is no layer",
                      "give some of specular,single,shallow,deep");
    }
  }
  return gains;
}

void write_screenshot(const ReviewRequest& request, const fs::path& png) {
  const FaceMaps face = face_from_maps(request.maps, request.fit.string());
  const float text_px = std::max(11.f, float(request.size.height) / 46.f);
  Window window("lamella", 64, 64, false, text_px);
  Renderer renderer(face, request.layers);
  renderer.light(request.lighting);
  SheetRequest sheet;
  sheet.subject = request.subject;
  sheet.size = request.size;
  const float aspect = 0.5f * float(request.size.width) / float(request.size.height);
  sheet.look.orbit = orbit_before(renderer.face(), aspect, 0.94f);
  sheet.look.orbit.azimuth_rad += request.azimuth_rad;
  sheet.look.orbit.elevation_rad = request.elevation_rad;
  sheet.look.gains = request.gains;
  sheet.look.exposure = request.exposure;
  const cv::Mat3b picture = draw_sheet(&renderer, window.fonts(), request.layers, sheet);
  write_whole_text(png, encode_png(picture, PngEffort::kSmall));
}

}  // namespace lamella::review
