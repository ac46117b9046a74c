// Step 2, geometry: left camera, right camera and projector column triangulated from the colour
// fringes; the projector and either camera suffice. Or a mesh that was given, as the left camera
// sees it.
#pragma once

#include "fit/burst.h"
#include "fit/depth_map.h"

namespace lamella::fit {

struct Geometry {
  Image3 position_mm;           // rig frame; NaN where nothing was measured
  Image1 sigma_mm;              // one sigma of the position along the ray
  Image2 projector_px;          // (u, v) that lights the pixel
  Image3 to_camera;             // v, unit
  Image3 to_projector;          // l, unit
  Image1 projector_irradiance;  // radiance of white facing the projector there; 1 at the origin
  Image3 scene_mm;  // position of every pixel that was measured, in a region or not: what
                    // casts shadows
  Mask measured;  // 255 where the pixel's own light was triangulated, or the mesh is seen, 0 where
                  // its depth is carried over from its neighbours
  Agreement right = {};
};

// Whoever gives away the only `burst` that has its fringes has their memory back before the rest
// is done.
Geometry reconstruct_geometry(Burst burst);

// Puts the point of `pixel` at `distance_mm` along its ray, and all that follows from where it is.
void move_along_ray(const Session& session, const cv::Point& pixel, float distance_mm,
                    Geometry* geometry);

}  // namespace lamella::fit
