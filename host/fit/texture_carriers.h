// What of a burst shows the skin's texture as if it were evenly lit: photographs, and sums of them.
#pragma once

#include <string>
#include <vector>

#include "calib/photographs.h"
#include "fit/registration.h"

namespace lamella::fit {

struct TextureCarrier {
  std::string name;    // "STRIPES 0 and 2"
  double time_us = 0;  // trigger; the mean of two
  Texture texture;
};

// Two of them, and how far what their light makes of the skin differs, mm.
struct CarrierLink {
  size_t from = 0, to = 0;
  double sigma_mm = 0;
};

struct TextureCarriers {
  std::vector<TextureCarrier> carriers;
  std::vector<CarrierLink> links;
  int bin_px = 1;       // pixels of a photograph in one of a texture, each way
  double pixel_mm = 1;  // of a texture's pixel, at the rig's origin
};

// One camera's. `labels`, in its pixels, may be empty. None where it has no FRONT or hardly any
// subject.
TextureCarriers texture_carriers(const Session& session, const Camera& camera,
                                 const Photographs& photographs, const Labels& labels);

}  // namespace lamella::fit
