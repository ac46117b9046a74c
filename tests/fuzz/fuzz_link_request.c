// Any bytes from a host: framed messages, one after the other, to a rig without a twin. Whatever
// comes, every message is answered or the connection closed, and every reply can be encoded.
#include <pb_encode.h>
#include <stdio.h>
#include <stdlib.h>

#include "hal_sim.h"
#include "link_answer.h"
#include "rig.h"
#include "session.h"
#include "store.h"
#include "wire.h"

static struct rig rig;
static uint8_t block[1 << 17];
static size_t replies;

static bool count_reply(void* context, const lamella_v1_Reply* reply) {
  (void)context;
  static uint8_t message[WIRE_MAX_MESSAGE_BYTES];
  pb_ostream_t stream = pb_ostream_from_buffer(message, sizeof message);
  if (!pb_encode(&stream, lamella_v1_Reply_fields, reply)) abort();
  replies++;
  return true;
}

// A finished burst whose photograph 1 is 100000 bytes, and a calibration.
static void set_up(struct session* session, struct dialogue* dialogue) {
  static struct hal_sim sim;
  static struct store store;
  if (rig.led_count == 0 && rig_read(LAMELLA_RIG_FILE, &rig) != LAM_OK) abort();
  if (hal_sim_open(&sim, &rig, SIM_CLOCK_VIRTUAL, kSimNoFaults, NULL) != LAM_OK) abort();
  store_init(&store, block, sizeof block);
  session_init(session, &rig, &sim.hal, &store);
  const struct photograph photograph = {.frame_id = 1, .size = 100000};
  store_keep(&store, &photograph);
  session->burst_id = session->done.burst_id = 1;
  dialogue->session = session;
  dialogue->calibration = block;
  dialogue->calibration_size = 5000;
  dialogue->greeted = true;
  dialogue->send = count_reply;
}

static void converse(struct session* session, struct dialogue* dialogue, const uint8_t* bytes,
                     size_t size) {
  while (size >= WIRE_LENGTH_BYTES) {
    size_t length = 0;
    if (!wire_get_length(bytes, &length) || length > size - WIRE_LENGTH_BYTES) return;
    replies = 0;
    const bool keep = link_answer(dialogue, bytes + WIRE_LENGTH_BYTES, length);
    if (replies == 0) abort();
    for (int i = 0; i < 10 && session_work(session); i++) link_tell_news(dialogue);
    if (!keep) return;
    bytes += WIRE_LENGTH_BYTES + length;
    size -= WIRE_LENGTH_BYTES + length;
  }
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  static struct session session;
  static struct dialogue dialogue;
  set_up(&session, &dialogue);
  converse(&session, &dialogue, bytes, size);
  session_close(&session);
  return 0;
}
