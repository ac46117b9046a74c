// What a run that was killed left behind.
#pragma once

#include <filesystem>

namespace lamella::apps {

// Says in a line how many folders a run that was killed left half-written beside `place`, if any,
// and removes them.
void clear_half_written_beside(const std::filesystem::path& place);

}  // namespace lamella::apps
