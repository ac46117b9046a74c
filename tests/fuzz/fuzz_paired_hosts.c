// Any text as the rig's list of paired hosts: taken whole, or refused by the number of a line.
#include <stdlib.h>
#include <string.h>

#include "link_trust.h"

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  static struct trust trust;
  const int line = trust_parse(&trust, (const char*)bytes, size);
  if (line < 0 || trust.count > TRUST_MAX_HOSTS) abort();
  for (size_t i = 0; i < trust.count; i++) {
    if (memchr(trust.hosts[i].name, '\0', TRUST_NAME_CHARS) == NULL) abort();
    if (strpbrk(trust.hosts[i].name, "\n\x1b") != NULL) abort();
  }
  return 0;
}
