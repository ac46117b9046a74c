// TLS 1.3 and nothing older, both ends certified, no authority: a host is let in because its key's
// fingerprint is among the trusted, or because it comes to be paired (by its ALPN) and is then
// spoken to about nothing else. No tickets, no early data: nothing can be replayed.
#ifndef LAMELLA_FIRMWARE_LINK_TLS_H
#define LAMELLA_FIRMWARE_LINK_TLS_H

#include "link_identity.h"
#include "link_stream.h"
#include "link_trust.h"

enum { CHANNEL_BYTES = 32 };

enum link_purpose { LINK_FOR_NOTHING, LINK_FOR_BURSTS, LINK_FOR_PAIRING };

// Who the other end of a finished handshake is, and what it came for.
struct link_peer {
  enum link_purpose purpose;
  uint8_t fingerprint[FINGERPRINT_BYTES];
  // The same at both ends of this one connection, and known to nobody else (RFC 5705, RFC 9266).
  uint8_t channel[CHANNEL_BYTES];
};

// NULL where OpenSSL will not. `identity` and `trust` must outlive it.
SSL_CTX* link_tls_context(const struct identity* identity, const struct trust* trust);

// False where anything is missing.
bool link_tls_peer(const struct link_stream* stream, struct link_peer* peer);

#endif
