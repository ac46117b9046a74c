// A fit as one .glb that opens anywhere.
#pragma once

#include <string>

#include "io/layer_maps.h"
#include "io/whole_file.h"

namespace lamella::exporting {

struct ExportOptions {
  int triangles = 24000;       // at most, about
  int texture_side_px = 1024;  // at most
};

struct ExportReport {
  size_t vertices = 0;
  size_t triangles = 0;
  size_t bytes = 0;
  double seconds = 0;
};

// Writes `file`, whole or not at all. `subject` names the node and, in an Error, the maps.
ExportReport export_face(const LayerMaps& maps, const v1::Layers& layers,
                         const std::string& subject, const fs::path& file,
                         const ExportOptions& options = {});

}  // namespace lamella::exporting
