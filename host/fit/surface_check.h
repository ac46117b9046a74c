// Normals come from the LEDs, positions from the projector: one surface, told twice.
#pragma once

#include "fit/normals.h"

namespace lamella::fit {

// Median angle, degrees, between the specular normals and the surface that the positions make,
// differenced over 6 mm; over labelled pixels whose own depth was measured, all five of them. NaN
// where there are fewer than a hundred.
double normals_off_surface_deg(const Burst& burst, const Geometry& geometry,
                               const Normals& normals);

}  // namespace lamella::fit
