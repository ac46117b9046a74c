// A fit against the truth: every figure under the name by which the project is judged.
#pragma once

#include <string>

#include "apps/compare_statistics.h"
#include "io/exr.h"

namespace lamella::apps {

// Throws Error where `found` is no fit or the truth cannot be read; what else is missing in
// `found`, of the wrong size or unanswered is listed as `problems`.
Json compare_folders(const fs::path& found, const fs::path& truth);

// The same as a table for people, units beside every column.
std::string comparison_table(const Json& figures);

}  // namespace lamella::apps
