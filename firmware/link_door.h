// Where connections come in: the listening socket, and guests whose handshake is under way. A guest
// costs others nothing: there are few places, a slow one is put out when its time is over or a new
// one needs the place.
#ifndef LAMELLA_FIRMWARE_LINK_DOOR_H
#define LAMELLA_FIRMWARE_LINK_DOOR_H

#include "link_tls.h"

enum { DOOR_GUESTS = 4 };

// Where and how to listen.
struct link_place {
  const char* address;  // "ADDRESS:PORT", IPv4; port 0: any
  const char* state;    // folder of key.pem and paired_hosts; NULL: plain TCP, on loopback alone
  const char* name;     // of the rig, for people; NULL: the machine's
};

struct guest {
  struct link_stream stream;
  double ends_us;
  bool refused;  // has been told so, and is given the time to hear it
};

struct link_door {
  int listener;      // -1: none
  char address[16];  // really bound
  uint16_t port;
  SSL_CTX* context;  // NULL: plain
  struct identity identity;
  struct trust trust;
  struct guest guests[DOOR_GUESTS];
};

// LAM_BAD_INPUT for an address that is none, or is beyond loopback without a state folder, or for a
// state folder that is of no use; LAM_HARDWARE where the port cannot be had. `error` is one line.
enum lam_status door_open(struct link_door* door, const struct link_place* place, char* error,
                          size_t error_size);
void door_close(struct link_door* door);

// A connection that waits becomes a guest.
void door_accept(struct link_door* door, double now_us);

// Goes on with a guest's handshake. LINK_DONE: `stream` and `peer` are the guest's, whose place is
// free again.
enum link_progress door_shake(struct link_door* door, struct guest* guest,
                              struct link_stream* stream, struct link_peer* peer);

// A guest that was told why it cannot stay is given the time to hear it: closed at once with bytes
// unread, a socket is reset, and what was said is lost.
void door_dismiss(struct link_door* door, const struct link_stream* stream, double now_us);

// Puts out guests whose time is over.
void door_put_out(struct link_door* door, double now_us);

#endif
