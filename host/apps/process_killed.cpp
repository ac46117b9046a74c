#include "apps/process_killed.h"

#include <fmt/format.h>

#include <cstdio>

#include "apps/counted.h"
#include "io/whole_file.h"

namespace lamella::apps {

void clear_half_written_beside(const fs::path& place) {
  const fs::path clean = place.has_filename() ? place : place.parent_path();
  const int count = remove_abandoned(clean.parent_path());
  if (count == 0) return;
  fmt::print(stderr, "lamella: {}: removed {} that a run that was killed had left beside it\n",
             place.string(), counted(uint64_t(count), "half-written folder"));
}

}  // namespace lamella::apps
