// `lamella review`: the fitted head, lit, layer by layer; in a window or as one picture.
#pragma once

#include <string>

#include "io/layer_maps.h"
#include "io/session.h"
#include "review/renderer.h"

namespace lamella::review {

struct ReviewRequest {
  fs::path session, fit;
  std::string subject;
  LayerMaps maps;
  v1::Layers layers;
  cv::Size size{1600, 900};
  LayerGains gains;  // 0: switched off
  Lighting lighting = portrait_lighting();
  float exposure = 1.15f;
  float azimuth_rad = -0.16f;  // from the side that was photographed
  float elevation_rad = 0.04f;
};

// "specular,single,shallow,deep" or part of it; "none" for none. Throws Error.
LayerGains gains_named(const std::string& names);

// The head and its layers as one PNG. Needs a display, which may be Xvfb's.
void write_screenshot(const ReviewRequest& request, const fs::path& png);

// Until the window is closed.
void show_window(const ReviewRequest& request);

}  // namespace lamella::review
