#include "base/grid_mesh.h"

namespace lamella {

namespace {

bool closer_than(const Vec3& a, const Vec3& b, float limit) {
  const Vec3 d = a - b;
  return dot(d, d) < limit * limit;
}

}  // namespace

GridMesh mesh_from_positions(const Image3& position_mm, int step, float max_edge_mm) {
  GridMesh mesh;
  const int rows = (position_mm.rows - 1) / step + 1, cols = (position_mm.cols - 1) / step + 1;
  cv::Mat1i index(rows, cols, -1);
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < cols; ++j) {
      const Vec3& p = position_mm(i * step, j * step);
      if (!is_finite(p)) continue;
      index(i, j) = int(mesh.vertices_mm.size());
      mesh.vertices_mm.push_back(p);
      mesh.pixel.emplace_back(j * step, i * step);
    }
  }
  const auto add = [&](int a, int b, int c) {
    if (a < 0 || b < 0 || c < 0) return;
    const auto& v = mesh.vertices_mm;
    if (closer_than(v[a], v[b], max_edge_mm) && closer_than(v[b], v[c], max_edge_mm) &&
        closer_than(v[c], v[a], max_edge_mm)) {
      mesh.triangles.emplace_back(a, b, c);
    }
  };
  for (int i = 0; i + 1 < rows; ++i) {
    for (int j = 0; j + 1 < cols; ++j) {
      add(index(i, j), index(i + 1, j), index(i + 1, j + 1));
      add(index(i, j), index(i + 1, j + 1), index(i, j + 1));
    }
  }
  return mesh;
}

}  // namespace lamella
