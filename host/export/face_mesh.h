// The face as an engine wants it: few triangles in cache order, with normals, tangents and UVs.
#pragma once

#include <cstdint>

#include "io/face_maps.h"

namespace lamella::exporting {

// glTF's axes are the rig's: +Y up, facing +Z, right-handed. Lengths become metres.
struct EngineVertex {
  Vec3 position_m;
  Vec3 normal;
  cv::Vec4f tangent;  // w: sign of the bitangent, cross(normal, tangent) w
  Vec2 uv;            // (0, 0) is the top left corner of the textures
};

struct EngineMesh {
  std::vector<EngineVertex> vertices;
  std::vector<uint32_t> indices;
};

// At most about `triangles` triangles. UVs are the place in the left camera's picture, cropped.
EngineMesh engine_mesh(const FaceMaps& face, int triangles);

}  // namespace lamella::exporting
