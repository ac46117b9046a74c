// What a fit spends: the knobs that trade seconds against error, and named settings of them all.
#pragma once

#include <string>

#include "layers.pb.h"

namespace lamella::fit {

// The defaults are `standard`: where `lamella bench` shows the knee of every curve.
struct Quality {
  std::string name = "standard";
  int bin_px = 1;             // pixels of a photograph averaged into one, each way
  int occlusion_rounds = 2;   // normals against what hides their light from them
  int relax_rounds = 1;       // depths against normals, once it is known which of them to link
  int lobe_samples = 6000;    // a region, for lobe and single scattering
  int lobe_rounds = 4;        // c against mixture and amplitudes
  int irradiance_cells = 49;  // a side of the table of what a normal receives

  bool operator==(const Quality&) const = default;
};

// draft, standard or reference. Throws Error that lists the names where `name` is none of them.
Quality quality_from_name(const std::string& name);

v1::Quality message_from_quality(const Quality& quality);

// Throws Error that names `where` and the field for what no fit can be run with.
Quality quality_from_message(const v1::Quality& message, const std::string& where);

}  // namespace lamella::fit
