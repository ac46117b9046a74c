// What the rig says to each request: one message in, replies out. No sockets here.
#ifndef LAMELLA_FIRMWARE_LINK_ANSWER_H
#define LAMELLA_FIRMWARE_LINK_ANSWER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/link.pb.h"
#include "session.h"
#include "standalone.h"

enum { LINK_PROTOCOL_VERSION = 1 };
#define LINK_FIRMWARE_VERSION "0.1.0"

// One host's conversation with the rig.
struct dialogue {
  struct session* session;
  const uint8_t* calibration;  // opaque bytes
  size_t calibration_size;
  struct standalone* alone;                                    // NULL: nobody to test the rig
  bool (*send)(void* context, const lamella_v1_Reply* reply);  // false: the host is gone
  // The same for a chunk whose data lies elsewhere and is not to be copied. NULL: send() takes all.
  bool (*send_chunk)(void* context, const lamella_v1_Reply* reply, const uint8_t* data,
                     size_t size);
  void* context;
  bool greeted;
  uint64_t aborted;        // Abort.attempt of the last abort that was carried out; 0: none
  lamella_v1_Reply reply;  // kept here as it is too large for a small stack
};

// Answers one message as it came. False where the connection is to be closed.
bool link_answer(struct dialogue* dialogue, const uint8_t* message, size_t length);

// Tells the host what happened since it was last told: a photograph more, a burst's end, a fault.
bool link_tell_news(struct dialogue* dialogue);

// An empty reply with this body, to be filled in and sent.
lamella_v1_Reply* link_begin(struct dialogue* dialogue, uint32_t request_id, pb_size_t body);
bool link_send(struct dialogue* dialogue);

bool link_refuse(struct dialogue* dialogue, uint32_t request_id, lamella_v1_Refusal_Code code,
                 const char* reason);

#endif
