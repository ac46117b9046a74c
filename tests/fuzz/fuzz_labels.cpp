// Any bytes as a label image.
#include "fuzz_input.h"
#include "io/labels.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  using namespace lamella;
  const fuzz::MemoryFile file(bytes, size);
  fuzz::expect_error_or_nothing([&] {
    if (read_labels(file.path()).empty()) std::abort();
  });
  return 0;
}
