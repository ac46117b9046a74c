// Any text as a view file, and as layers.json.
#include "fuzz_input.h"
#include "io/json.h"
#include "io/view.h"
#include "layers.pb.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  using namespace lamella;
  const fuzz::MemoryFile file(bytes, size);
  fuzz::expect_error_or_nothing([&] {
    const View view = read_view(file.path(), 3);
    if (view.lights.empty() || view.camera.width < 1) std::abort();
  });
  fuzz::expect_error_or_nothing([&] {
    v1::Layers layers;
    parse_json({reinterpret_cast<const char*>(bytes), size}, "layers.json", &layers,
               NonFinite::kAllowed);
    to_json(layers);
  });
  return 0;
}
