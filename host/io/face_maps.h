// The maps of a fit as a face to show: cropped to one smooth outline, every pixel with an answer.
#pragma once

#include "base/face_surface.h"
#include "io/layer_maps.h"

namespace lamella {

struct FaceMaps {
  FaceOutline outline;
  LayerMaps maps;  // of the outline's box; unknown pixels filled from those around them
};

// Takes the pixels that have a position, a normal and a diffuse albedo that is not black. Throws
// Error (`where` names the folder) where nothing is left. Maps that are empty stay empty.
FaceMaps face_from_maps(const LayerMaps& measured, const std::string& where);

}  // namespace lamella
