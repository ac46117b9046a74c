// Normals of the map relative to the mesh that carries them.
#pragma once

#include "export/face_mesh.h"

namespace lamella::exporting {

// Tangent-space normals of the map: what a renderer must add to the mesh's interpolated frame.
Image3 tangent_space_normals(const Image3& normal, const EngineMesh& mesh);

}  // namespace lamella::exporting
