// Any bytes as a label image, and as one that is given instead of a session's.
#include "fuzz_input.h"
#include "io/given_regions.h"
#include "io/labels.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  using namespace lamella;
  const fuzz::MemoryFile file(bytes, size);
  fuzz::expect_error_or_nothing([&] {
    if (read_labels(file.path()).empty()) std::abort();
  });
  fuzz::expect_error_or_nothing([&] {
    Session session;
    session.left.width = session.left.height = 8;
    give_regions(file.path(), &session);
    if (session.region_names.size() < 2) std::abort();
  });
  return 0;
}
