// Any text as session.json: it is read whole or refused with one line.
#include <fstream>

#include "fuzz_input.h"
#include "io/session.h"

namespace {

// A session folder with the two files that the seed's manifest names.
std::filesystem::path session_folder() {
  static const std::filesystem::path folder = [] {
    std::string name = "/tmp/lamella-fuzz-XXXXXX";
    if (!mkdtemp(name.data())) std::abort();
    std::ofstream(name + "/f.exr") << "never opened";
    std::atexit([] { std::filesystem::remove_all(session_folder()); });
    return std::filesystem::path(name);
  }();
  return folder;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  const auto folder = session_folder();
  std::ofstream(folder / "session.json", std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes), std::streamsize(size));
  lamella::fuzz::expect_error_or_nothing([&] {
    const lamella::Session session = lamella::read_session(folder);
    lamella::require_burst(session);
  });
  return 0;
}
