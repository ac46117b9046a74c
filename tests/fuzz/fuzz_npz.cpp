// Any bytes as a NumPy archive: an array of as many numbers as its shape says, or one line.
#include <functional>
#include <numeric>

#include "apps/compare_npz.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  using namespace lamella;
  const fuzz::MemoryFile file(bytes, size);
  for (const char* name : {"r", "R"}) {
    fuzz::expect_error_or_nothing([&] {
      const apps::NpzArray array = apps::read_npz(file.path(), name);
      const size_t count = std::accumulate(array.shape.begin(), array.shape.end(), size_t(1),
                                           std::multiplies<size_t>());
      if (count != array.values.size()) std::abort();
    });
  }
  return 0;
}
