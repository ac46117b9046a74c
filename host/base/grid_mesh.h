// A triangle mesh from a map of positions: two triangles a pixel quad, none across a gap.
#pragma once

#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace lamella {

struct GridMesh {
  std::vector<Vec3> vertices_mm;
  std::vector<cv::Vec3i> triangles;  // counter-clockwise seen from outside
  std::vector<cv::Point> pixel;      // of each vertex, in the map it came from
};

// `position_mm`: NaN where nothing was measured. Every `step`-th pixel becomes a vertex. A quad
// with an edge longer than `max_edge_mm` is a silhouette and is left open.
GridMesh mesh_from_positions(const Image3& position_mm, int step, float max_edge_mm);

}  // namespace lamella
