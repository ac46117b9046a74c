// A triangle mesh that another program made. PLY (ASCII or binary) and OBJ give millimetres in the
// rig's frame; GLB gives metres, as glTF says, and is what `export` writes.
#pragma once

#include <filesystem>
#include <vector>

#include "base/vec.h"

namespace lamella {

struct TriangleMesh {
  std::filesystem::path file;
  std::vector<Vec3> vertices_mm;     // finite
  std::vector<cv::Vec3i> triangles;  // of vertices that are there; either way round
};

// The format is told by the first bytes, not by the name. A polygon becomes a fan of triangles.
// Colours, normals and the like are passed over. Throws Error (kBadInput) that names the file and
// what is wrong in it.
TriangleMesh read_mesh(const std::filesystem::path& path);

}  // namespace lamella
