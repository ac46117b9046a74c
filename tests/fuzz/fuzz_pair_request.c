// Any bytes from a host that came to be paired, while the button is held and let go at any time. No
// sequence of them lets a host in: nobody here knows the code.
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "link_pair.h"

static bool ignore_reply(void* context, const lamella_v1_PairReply* reply) {
  (void)context;
  return reply->which_body != 0;
}

static void open_trust(struct trust* trust) {
  static char folder[] = "/tmp/lamella-fuzz-pair-XXXXXX";
  static bool made;
  char error[400];
  if (!made && mkdtemp(folder) == NULL) abort();
  made = true;
  if (trust_open(trust, folder, error, sizeof error) != LAM_OK) abort();
}

// Each step: a byte that says how long it waits and whether the button is down, a length, a
// message.
int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  static struct trust trust;
  static struct identity identity;
  static struct pair pair;
  static const struct link_peer host = {.purpose = LINK_FOR_PAIRING, .fingerprint = {7}};
  if (trust.path[0] == '\0') open_trust(&trust);
  pair_init(&pair, &trust, &identity, "rig");
  pair.send = ignore_reply;
  double now_us = 1e6;
  pair_begin(&pair, &host, now_us);
  while (size >= 2) {
    const size_t length = bytes[1] < size - 2 ? bytes[1] : size - 2;
    now_us += (bytes[0] & 0x7F) * 50e3;
    if (!pair_tick(&pair, bytes[0] & 0x80, now_us)) break;
    pair_light(&pair, now_us);
    if (length > 0 && !pair_answer(&pair, bytes + 2, length, now_us)) break;
    bytes += 2 + length;
    size -= 2 + length;
  }
  pair_end(&pair);
  if (trust_knows(&trust, host.fingerprint)) abort();
  return 0;
}
