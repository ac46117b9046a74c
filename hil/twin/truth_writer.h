// Writes `truth/` and regions.png of a subject.
#pragma once

#include "twin/photographer.h"

namespace lamella::twin {

// regions.png in `folder`, everything else in `folder`/truth.
void write_truth(const fs::path& folder, const Photographer& photographer);

}  // namespace lamella::twin
