// Meshes as other programs write them, for tests of what reads them.
#pragma once

#include <fstream>
#include <sstream>

#include "base/grid_mesh.h"
#include "io/whole_file.h"

namespace lamella::testing {

template <class Number>
void put_binary(std::ostream& to, Number number) {
  to.write(reinterpret_cast<const char*>(&number), sizeof number);
}

inline std::string ply_header(const std::string& format, size_t vertices, size_t triangles) {
  std::ostringstream header;
  header << "ply\nformat " << format << " 1.0\nelement vertex " << vertices
         << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << triangles
         << "\nproperty list uchar int vertex_indices\nend_header\n";
  return header.str();
}

// Binary, as scanners do.
inline void write_ply(const fs::path& path, const std::vector<Vec3>& vertices,
                      const std::vector<cv::Vec3i>& triangles) {
  std::ofstream out(path, std::ios::binary);
  out << ply_header("binary_little_endian", vertices.size(), triangles.size());
  for (const Vec3& v : vertices) {
    for (const float x : v.val) put_binary(out, x);
  }
  for (const cv::Vec3i& triangle : triangles) {
    put_binary(out, uint8_t(3));
    for (const int corner : triangle.val) put_binary(out, int32_t(corner));
  }
}

// The surface that a map of positions shows, a vertex every `step` pixels.
inline void write_ply(const fs::path& path, const Image3& position_mm, int step,
                      float max_edge_mm) {
  const GridMesh mesh = mesh_from_positions(position_mm, step, max_edge_mm);
  write_ply(path, mesh.vertices_mm, mesh.triangles);
}

// The chunks of a GLB, lengths and all.
inline std::string glb_of(std::string json, std::string binary) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  std::ostringstream out;
  out << "glTF";
  put_binary(out, uint32_t(2));
  put_binary(out, uint32_t(12 + 8 + json.size() + 8 + binary.size()));
  put_binary(out, uint32_t(json.size()));
  out << "JSON" << json;
  put_binary(out, uint32_t(binary.size()));
  out.write("BIN\0", 4);
  out << binary;
  return out.str();
}

}  // namespace lamella::testing
