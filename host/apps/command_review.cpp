// lamella review: the lit head, every layer switchable, in a window or as a picture.
#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "apps/commands.h"
#include "apps/output_place.h"
#include "base/error.h"
#include "io/fit_folder.h"
#include "io/session.h"
#include "review/display.h"
#include "review/review.h"

namespace lamella::apps {

namespace {

struct ReviewArguments {
  fs::path session, fit, screenshot;
  std::string size = "1600x900", layers = "specular,single,shallow,deep", light = "portrait";
  double azimuth_deg = 6, elevation_deg = 2;
  float exposure = 1.15f;
};

cv::Size parsed_size(const std::string& text) {
  cv::Size size;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &size.width, &size.height, &rest) != 2 ||
      size.width < 200 || size.height < 200 || size.width > 8192 || size.height > 8192) {
    throw_bad_input("--size", "\"" + text + "\" is no size", "give WIDTHxHEIGHT, 200 to 8192 each");
  }
  return size;
}

void run(const ReviewArguments& a) {
  review::ReviewRequest request;
  request.session = a.session;
  request.fit = a.fit.empty() ? a.session / "fit" : a.fit;
  if (!a.screenshot.empty()) {
    prepare_output(a.screenshot, ".png", {request.session, request.fit, {}});
  }
  request.subject = read_session(a.session).subject;
  request.size = parsed_size(a.size);
  request.gains = review::gains_named(a.layers);
  request.lighting = review::lighting_named(a.light);
  request.azimuth_rad = float(a.azimuth_deg * M_PI / 180);
  request.elevation_rad = float(a.elevation_deg * M_PI / 180);
  request.exposure = a.exposure;
  if (!a.screenshot.empty()) review::ensure_display();
  FitFolder fit = read_fit_folder(request.fit);
  request.maps = std::move(fit.maps);
  request.layers = std::move(fit.layers);
  if (a.screenshot.empty()) {
    review::show_window(request);
  } else {
    review::write_screenshot(request, a.screenshot);
    fmt::print("wrote {}: {} pixels\n", a.screenshot.string(), size_words(request.size));
  }
}

}  // namespace

void add_review(const Command& app, int*) {
  auto a = std::make_shared<ReviewArguments>();
  const Command command = app.add_command("review", "Look at a fitted face, lit, layer by layer");
  command.add_option("session", a->session, "Session folder").required();
  command.add_option("--fit", a->fit, "Folder of the fit [SESSION/fit]");
  command.add_option("--screenshot", a->screenshot, "PNG to write, instead of a window");
  command.add_option("--size", a->size, "WIDTHxHEIGHT of the window or picture, pixels")
      .shows_default();
  command.add_option("--layers", a->layers, "Some of specular,single,shallow,deep; or none")
      .shows_default();
  command.add_option("--light", a->light, "portrait, front, side, or a direction X,Y,Z")
      .shows_default();
  command
      .add_option("--azimuth", a->azimuth_deg,
                  "Of the camera, degrees from the side that was photographed")
      .within(-360.0, 360.0)
      .shows_default();
  command.add_option("--elevation", a->elevation_deg, "Of the camera, degrees")
      .within(-85.0, 85.0)
      .shows_default();
  command.add_option("--exposure", a->exposure, "Factor on the picture")
      .within(0.01, 100.0)
      .shows_default();
  command.runs([a] { run(*a); });
}

}  // namespace lamella::apps
