#include "apps/process_killed.h"

#include <fmt/format.h>

#include <cstdio>

#include "apps/counted.h"
#include "io/whole_file.h"

namespace lamella::apps {

void clear_half_written_in(const fs::path& folder) {
  const int count = remove_abandoned(folder);
  if (count == 0) return;
  fmt::print(stderr, "lamella: {}: removed {} that a run that was killed had left there\n",
             folder.empty() ? "." : folder.string(),
             counted(uint64_t(count), "half-written output"));
}

void clear_half_written_beside(const fs::path& place) {
  const fs::path named = place.has_filename() ? place : place.parent_path();
  clear_half_written_in(file_behind(named).parent_path());
}

}  // namespace lamella::apps
