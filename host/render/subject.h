// What there is to draw: the maps and numbers of a fit, and the rig whose lights can shine on them.
#pragma once

#include "io/layer_maps.h"
#include "io/session.h"

namespace lamella::render {

struct Subject {
  LightStage stage;
  Camera left;  // whose pixels the maps are in
  Camera projector;
  LayerMaps maps;
  v1::Layers layers;
  std::vector<std::string> region_names;  // by label; [0] is the background

  // What layers.json says of a label; nullptr where it says nothing.
  const v1::Region* region(int label) const;
};

// Reads the session's rig and the maps and layers.json of `fit_folder` (of `truth/` likewise).
// Throws Error that names the file where one is missing or of another size than the left camera.
Subject load_subject(const fs::path& session_folder, const fs::path& fit_folder);

}  // namespace lamella::render
