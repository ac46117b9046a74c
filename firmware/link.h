// The server on the link: one host at a time, over TLS where there is a state folder (link_door.h),
// and beside it one that is being paired. Nothing here waits while edges are played.
#ifndef LAMELLA_FIRMWARE_LINK_H
#define LAMELLA_FIRMWARE_LINK_H

#include <signal.h>

#include "link_answer.h"
#include "link_door.h"
#include "link_pair.h"
#include "wire.h"

enum { LINK_PAIR_ROOM = WIRE_LENGTH_BYTES + 512 };

struct link_server {
  struct link_door door;
  double hello_by_us;  // of the host's connection
  struct link_stream host, pairing;
  // What else the serving loop tends to, in every gap long enough to be heard in. Returns when it
  // is due again, on the rig's clock. NULL: nothing.
  double (*tend)(void* context);
  void* tend_context;
  struct dialogue dialogue;
  struct pair pair;
  bool light;  // that shows the pairing code
  uint8_t received[WIRE_LENGTH_BYTES + WIRE_MAX_MESSAGE_BYTES];
  size_t received_count;
  uint8_t pair_received[LINK_PAIR_ROOM];
  size_t pair_received_count;
  uint8_t outgoing[WIRE_LENGTH_BYTES + WIRE_MAX_MESSAGE_BYTES];
};

// As door_open().
enum lam_status link_listen(struct link_server* server, const struct link_place* place, char* error,
                            size_t error_size);

// Serves hosts and works on bursts until *stop is not 0.
void link_serve(struct link_server* server, struct session* session, volatile sig_atomic_t* stop);

// The pairing code, for whoever tends to the operator's light. False: there is none to show.
bool link_code_light(const struct link_server* server, bool* light);

void link_close(struct link_server* server);

#endif
