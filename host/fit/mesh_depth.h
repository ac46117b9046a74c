// The shape of a subject that was given as a mesh: how far it is along every pixel's ray.
#pragma once

#include "fit/depth_map.h"
#include "io/mesh_file.h"

namespace lamella::fit {

// Taken of a mesh that nobody says more of: a good scanner's.
inline constexpr float kMeshSigmaMm = 0.1f;

// Throws Error where the mesh is not the subject that `regions` show: `camera` sees next to nothing
// of it there, or sees it where no subject is. It is in other units, then, or another frame.
DepthMap mesh_depth(const Camera& camera, const TriangleMesh& mesh, const Labels& regions);

}  // namespace lamella::fit
