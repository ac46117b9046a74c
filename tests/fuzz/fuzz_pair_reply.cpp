// Any bytes as the answers of a rig that a host wants to be paired with: it is never paired, as
// such a rig does not know the code.
#include <arpa/inet.h>
#include <sys/socket.h>

#include <thread>

#include "fuzz_input.h"
#include "io/pairing.h"

namespace {

using namespace lamella;

// Without TLS: what is fuzzed is what comes after it.
void converse(int rig, const uint8_t* bytes, size_t size) {
  send(rig, bytes, size, MSG_NOSIGNAL);
  shutdown(rig, SHUT_WR);
  char ignored[4096];
  while (recv(rig, ignored, sizeof ignored, 0) > 0) {
  }
  close(rig);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) std::abort();
  std::thread rig([&] { converse(ends[1], bytes, size); });
  fuzz::expect_error_or_nothing([&] {
    PairingOptions options;
    options.reply_s = 1;
    options.wait_s = 0;
    options.read_code = [] { return "12345"; };
    PairSecret secret;
    hold_ceremony(Socket(ends[0]), "fuzz", secret, options);
    std::abort();
  });
  rig.join();
  return 0;
}
