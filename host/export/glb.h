// A binary glTF 2.0 file from a mesh, textures and words. Ratified extensions only, none required.
#pragma once

#include "export/textures.h"
#include "io/whole_file.h"

namespace lamella::exporting {

struct GlbContent {
  std::string subject;
  EngineMesh mesh;
  FaceTextures textures;
  v1::Layers layers;  // into the material's extras
};

void write_glb(const fs::path& path, const GlbContent& content);

}  // namespace lamella::exporting
