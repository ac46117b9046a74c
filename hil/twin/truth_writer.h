// Writes what is known of a subject: the folder `truth/` of a session.
#pragma once

#include "twin/photographer.h"

namespace lamella::twin {

// Maps, labels, layers.json, kernels and views, straight into `folder`.
void write_truth(const fs::path& folder, const Photographer& photographer);

}  // namespace lamella::twin
