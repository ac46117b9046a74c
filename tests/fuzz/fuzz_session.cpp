// Any text as session.json: it is read whole or refused with one line.
#include <fstream>

#include "fuzz_input.h"
#include "io/session.h"

namespace {

// A session folder with the one file that the seed's manifest names.
struct SessionFolder {
  std::string path = "/tmp/lamella-fuzz-XXXXXX";

  SessionFolder() {
    if (!mkdtemp(path.data())) std::abort();
    std::ofstream(path + "/f.exr") << "never opened";
  }
  ~SessionFolder() { std::filesystem::remove_all(path); }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  static const SessionFolder session_folder;
  const std::filesystem::path folder = session_folder.path;
  std::ofstream(folder / "session.json", std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes), std::streamsize(size));
  lamella::fuzz::expect_error_or_nothing([&] {
    const lamella::Session session = lamella::read_session(folder);
    lamella::require_burst(session);
  });
  return 0;
}
