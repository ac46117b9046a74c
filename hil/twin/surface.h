// The surface of a subject as a grid of vertices: what light falls on and scatters between.
#pragma once

#include <memory>
#include <vector>

#include "base/ray_scene.h"
#include "twin/subject.h"

namespace lamella::twin {

// Rows go down, columns once around the vertical axis; the last column meets the first.
struct Surface {
  int rows = 0, columns = 0;
  std::vector<Vec3> position_mm, normal, shading_normal;  // rows * columns
  std::vector<float> area_mm2;                            // of the patch a vertex stands for
  std::vector<cv::Vec3i> triangles;                       // counter-clockwise seen from outside
  std::unique_ptr<RayScene> scene;

  size_t size() const { return position_mm.size(); }
  int at(int row, int column) const { return row * columns + (column + columns) % columns; }
};

// `spacing_mm` between vertices on the side of the cameras; coarser behind.
Surface make_surface(const Subject& subject, float spacing_mm);

}  // namespace lamella::twin
