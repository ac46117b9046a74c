// What a face shows of its skin before any layer is fitted, in cells of about two millimetres.
#pragma once

#include <vector>

#include "fit/normals.h"

namespace lamella::fit {

// Means over the pixels of a cell that are seen well: lit and looked at from in front, not hidden
// from the LEDs, not clipped.
struct SkinCell {
  double area_mm2 = 0;         // of them, as the camera sees it; 0: the cell says nothing
  double peak_mm2 = 0;         // of that, within 10 degrees of FRONT's mirror direction
  double red = 0, yellow = 0;  // log(R/G), log(G/B) of the diffuse reflectance
  double light = 0;            // log of its mean
  // How closely S keeps to the mirror direction (cosine), and log S: what each is above the middle
  // of all cells that are looked at under the same angle.
  double gloss = 0, sheen = 0;
};

struct SkinCells {
  int step_px = 1;  // a cell's side
  cv::Size size;
  std::vector<SkinCell> cells;  // row by row
};

SkinCells skin_cells(const Burst& burst, const Geometry& geometry, const Normals& normals);

}  // namespace lamella::fit
