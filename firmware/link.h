// The server on the link: one host at a time over TCP, on loopback only until pairing exists.
#ifndef LAMELLA_FIRMWARE_LINK_H
#define LAMELLA_FIRMWARE_LINK_H

#include <signal.h>

#include "link_answer.h"
#include "wire.h"

struct link_server {
  int listener, host;  // sockets; -1: none
  uint16_t port;       // the one really bound
  // What else the serving loop tends to, in every gap long enough to be heard in. Returns when it
  // is due again, on the rig's clock. NULL: nothing.
  double (*tend)(void* context);
  void* tend_context;
  struct dialogue dialogue;
  uint8_t received[WIRE_LENGTH_BYTES + WIRE_MAX_MESSAGE_BYTES];
  size_t received_count;
  uint8_t outgoing[WIRE_LENGTH_BYTES + WIRE_MAX_MESSAGE_BYTES];
};

// Binds "127.0.0.1:PORT" (port 0: any). LAM_BAD_INPUT for what is no loopback address,
// LAM_HARDWARE where the port cannot be had; `error` is one line either way.
enum lam_status link_listen(struct link_server* server, const char* address, char* error,
                            size_t error_size);

// Serves hosts and works on bursts until *stop is not 0.
void link_serve(struct link_server* server, struct session* session, volatile sig_atomic_t* stop);

void link_close(struct link_server* server);

#endif
