// The photographs of a burst, read once for whoever judges them and whoever fits them.
#pragma once

#include <map>
#include <vector>

#include "io/session.h"

namespace lamella {

using Photographs = std::map<const Frame*, Photograph>;

// Does the right camera have what its depth needs: every FRINGE, FRONT and BLACK, crossed?
bool has_right_geometry(const Session& session);

// What a fit reads: the left camera's burst and AMBIENT, and the right camera's part of the
// geometry. Frames that are not there are left out (`require_burst` names them); with a mesh, so
// are those that only the geometry needs.
std::vector<const Frame*> frames_to_fit(const Session& session,
                                        ShapeFrom shape = ShapeFrom::kFringes);

// In parallel, the first of `frames` first. Throws Error that names the file and what is wrong with
// it.
Photographs read_photographs(const Session& session, const std::vector<const Frame*>& frames);

}  // namespace lamella
