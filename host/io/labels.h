// Label images and masks: 8-bit grey PNG, one number a pixel, 0 the background.
#pragma once

#include "base/vec.h"
#include "io/exr.h"

namespace lamella {

// Throws Error where the file is missing, damaged, or no 8-bit grey image.
Labels read_labels(const fs::path& file);

// Whole or not at all.
void write_labels(const fs::path& file, const Labels& labels);

}  // namespace lamella
