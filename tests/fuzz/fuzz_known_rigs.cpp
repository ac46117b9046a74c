// Any text as the host's list of paired rigs.
#include "fuzz_input.h"
#include "io/known_rigs.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  lamella::fuzz::expect_error_or_nothing([&] {
    const std::string text(reinterpret_cast<const char*>(bytes), size);
    for (const lamella::KnownRig& rig : lamella::KnownRigs::parse(text, "known_rigs")) {
      if (rig.name.empty() || rig.address.empty()) std::abort();
    }
  });
  return 0;
}
