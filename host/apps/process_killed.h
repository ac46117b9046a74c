// What a run that was killed left behind.
#pragma once

#include <filesystem>

namespace lamella::apps {

// Says in a line how much a run that was killed left half-written in `folder`, if anything, and
// removes it.
void clear_half_written_in(const std::filesystem::path& folder);

// The same in the folder that `place` is in.
void clear_half_written_beside(const std::filesystem::path& place);

}  // namespace lamella::apps
