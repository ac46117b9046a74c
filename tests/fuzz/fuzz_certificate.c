// Any bytes as a peer's certificate.
#include "link_identity.h"

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  uint8_t fingerprint[FINGERPRINT_BYTES];
  char hex[FINGERPRINT_HEX + 1];
  if (identity_fingerprint_der(bytes, size, fingerprint)) fingerprint_to_hex(fingerprint, hex);
  return 0;
}
