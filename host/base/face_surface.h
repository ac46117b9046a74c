// The part of the left camera's picture that is shown as a face: small holes closed, one smooth
// outline, and a triangle mesh that ends on that outline instead of on a staircase of pixels.
#pragma once

#include <vector>

#include "base/vec.h"

namespace lamella {

struct FaceOutline {
  cv::Rect box;      // in map pixels
  Image1 inside_px;  // of the box: distance to the outline, pixels, positive inside
  Mask torn;         // of the box: 255 beside a jump in depth, where nothing is reliable
};

// `known`: 255 where a map has an answer. Where the surface jumps in depth the face is cut open.
// Empty box: nothing to show.
FaceOutline outline_face(const Image3& position_mm, const Mask& known);

struct FaceMesh {
  std::vector<Vec3> vertices_mm;
  std::vector<Vec2> pixel;           // of each vertex, in the box
  std::vector<cv::Vec3i> triangles;  // counter-clockwise seen from the camera
};

// Both images are of the outline's box; `position_mm` is filled to a pixel beyond the outline. A
// vertex every `step` pixels; those of the border are moved onto the outline.
FaceMesh mesh_face(const Image3& position_mm, const Image1& inside_px, int step);

// Nearest pixel, clamped to the image.
bool is_inside(const Image1& inside_px, Vec2 pixel);

// Bilinear, clamped to the image.
Vec3 sample(const Image3& image, Vec2 pixel);

}  // namespace lamella
