// One connection's bytes, plain or inside TLS. Nothing here waits longer than it is told to.
#ifndef LAMELLA_FIRMWARE_LINK_STREAM_H
#define LAMELLA_FIRMWARE_LINK_STREAM_H

#include <openssl/types.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct link_stream {
  int socket;     // -1: none
  SSL* tls;       // NULL: plain
  char fate[96];  // why it is of no more use, where somebody may want to know
};

enum link_progress { LINK_LATER, LINK_DONE, LINK_GONE };

extern const struct link_stream kNoStream;

// Takes over a connected socket; on TLS, where there is a context, from its first byte on.
// LINK_GONE leaves the socket closed.
enum link_progress link_stream_open(struct link_stream* stream, int socket, SSL_CTX* context);
void link_stream_close(struct link_stream* stream);

// As much of the handshake as the bytes that are here allow. In the clear it is over with the first
// of them: who says nothing is no peer.
enum link_progress link_stream_shake(struct link_stream* stream);

// Bytes read, 0 where none are here yet, -1 where the other end is gone.
int link_stream_read(struct link_stream* stream, uint8_t* bytes, size_t room);

// Bytes that poll() does not see: they are decrypted, or in our own buffer.
bool link_stream_has_more(const struct link_stream* stream);

// All of it within the time, or false: the stream is of no more use then.
bool link_stream_write(struct link_stream* stream, const uint8_t* bytes, size_t count,
                       int patience_ms);

#endif
