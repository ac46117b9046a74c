#define _GNU_SOURCE
#include "link.h"

#include <math.h>
#include <pb_encode.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "complain.h"

// While edges are played the link is heard only in gaps this long: a short answer fits many times,
// and a step of a handshake (a millisecond or two on a small board) fits into the longer ones.
static const double kListenGapUs = 5000, kShakeGapUs = 20000;
static const double kLongestPollUs = 200000;
static const double kPairPollUs = 40000;  // how smoothly the code blinks
static const double kHelloUs = 2e6;       // a host that says hello later keeps others out
// On a real clock the loop sleeps until this long before an edge, and looks at the rig this often.
static const double kReadyUs = 1000;
static const double kWatchEveryUs = 2000;
static const int kSendTimeoutMs = 2000;  // below the service manager's watchdog

enum { LISTENER, HOST, PAIRING, FIRST_GUEST, POLLED = FIRST_GUEST + DOOR_GUESTS };

static double now_us(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec * 1e6 + (double)now.tv_nsec * 1e-3;
}

static bool send_frame(struct link_server* server, struct link_stream* stream,
                       const pb_msgdesc_t* fields, const void* message) {
  uint8_t* frame = server->outgoing;
  pb_ostream_t out = pb_ostream_from_buffer(frame + WIRE_LENGTH_BYTES, WIRE_MAX_MESSAGE_BYTES);
  if (!pb_encode(&out, fields, message)) return false;
  wire_put_length(frame, out.bytes_written);
  const struct session* session = server->dialogue.session;
  const bool playing = session != NULL && session->playing;
  return link_stream_write(stream, frame, WIRE_LENGTH_BYTES + out.bytes_written,
                           playing ? 0 : kSendTimeoutMs);
}

static bool send_to_host(void* context, const lamella_v1_Reply* reply) {
  struct link_server* server = context;
  return server->host.socket >= 0 &&
         send_frame(server, &server->host, lamella_v1_Reply_fields, reply);
}

// Everything of a chunk's frame that comes before its data, as nanopb would write it: data is the
// last field of the last field. 0 where it cannot be.
static size_t encode_chunk_prefix(uint8_t* frame, size_t room, const lamella_v1_Reply* reply,
                                  size_t data_size) {
  uint8_t fields[128];
  pb_ostream_t inner = pb_ostream_from_buffer(fields, sizeof fields);
  pb_ostream_t out = pb_ostream_from_buffer(frame + WIRE_LENGTH_BYTES, room - WIRE_LENGTH_BYTES);
  const bool encoded =
      pb_encode(&inner, lamella_v1_Chunk_fields, &reply->body.chunk) &&
      (data_size == 0 || (pb_encode_tag(&inner, PB_WT_STRING, lamella_v1_Chunk_data_tag) &&
                          pb_encode_varint(&inner, data_size))) &&
      pb_encode_tag(&out, PB_WT_VARINT, lamella_v1_Reply_request_id_tag) &&
      pb_encode_varint(&out, reply->request_id) &&
      pb_encode_tag(&out, PB_WT_STRING, lamella_v1_Reply_chunk_tag) &&
      pb_encode_varint(&out, inner.bytes_written + data_size) &&
      pb_write(&out, fields, inner.bytes_written);
  if (!encoded) return 0;
  wire_put_length(frame, out.bytes_written + data_size);
  return WIRE_LENGTH_BYTES + out.bytes_written;
}

// The prefix and as much data as a TLS record takes beside it, then the rest from where it lies.
static bool send_chunk_to_host(void* context, const lamella_v1_Reply* reply, const uint8_t* data,
                               size_t size) {
  enum { RECORD_BYTES = 16384 };
  struct link_server* server = context;
  uint8_t* frame = server->outgoing;
  const size_t prefix = encode_chunk_prefix(frame, RECORD_BYTES, reply, size);
  if (prefix == 0 || server->host.socket < 0) return false;
  const size_t room = RECORD_BYTES - prefix, first = size < room ? size : room;
  memcpy(frame + prefix, data, first);
  return link_stream_write(&server->host, frame, prefix + first, kSendTimeoutMs) &&
         link_stream_write(&server->host, data + first, size - first, kSendTimeoutMs);
}

static bool send_to_pairing(void* context, const lamella_v1_PairReply* reply) {
  struct link_server* server = context;
  return server->pairing.socket >= 0 &&
         send_frame(server, &server->pairing, lamella_v1_PairReply_fields, reply);
}

enum lam_status link_listen(struct link_server* server, const struct link_place* place, char* error,
                            size_t error_size) {
  memset(server, 0, sizeof *server);
  server->host = server->pairing = kNoStream;
  const enum lam_status status = door_open(&server->door, place, error, error_size);
  if (status != LAM_OK) return status;
  char machine[TRUST_NAME_CHARS] = "rig";
  if (place->name == NULL) gethostname(machine, sizeof machine - 1);
  pair_init(&server->pair, &server->door.trust, &server->door.identity,
            place->name != NULL ? place->name : machine);
  server->pair.send = send_to_pairing;
  server->pair.context = server;
  return LAM_OK;
}

static void hang_up(struct link_server* server) {
  link_stream_close(&server->host);
  server->received_count = 0;
  server->dialogue.greeted = false;
}

static void lose_host(struct link_server* server) {
  session_lose_host(server->dialogue.session);
  hang_up(server);
}

bool link_code_light(const struct link_server* server, bool* light) {
  if (!pair_is_showing(&server->pair)) return false;
  *light = pair_light(&server->pair, now_us());
  return true;
}

// Where nobody else has the operator's light, the code is shown from here.
static void show_code(struct link_server* server) {
  bool light = false;
  link_code_light(server, &light);
  if (server->tend != NULL || light == server->light) return;
  struct hal* hal = server->dialogue.session->hal;
  double at_us = 0;
  const bool shown = hal->set_line(hal->self, HAL_READY, light, &at_us) == LAM_OK &&
                     hal->set_line(hal->self, HAL_BUZZER, light, &at_us) == LAM_OK;
  if (!shown) complain("lamella-rigd: the pairing code cannot be shown: %s", hal->error);
  server->light = light;
}

static void end_pairing(struct link_server* server) {
  pair_end(&server->pair);
  link_stream_close(&server->pairing);
  server->pair_received_count = 0;
}

void link_close(struct link_server* server) {
  hang_up(server);
  end_pairing(server);
  door_close(&server->door);
}

// A second host is told so and left.
static void turn_away(struct link_server* server, struct link_stream* stream) {
  static lamella_v1_Reply reply;
  reply = (lamella_v1_Reply)lamella_v1_Reply_init_zero;
  reply.which_body = lamella_v1_Reply_refusal_tag;
  reply.body.refusal.code = lamella_v1_Refusal_Code_WRONG_STATE;
  snprintf(reply.body.refusal.reason, sizeof reply.body.refusal.reason,
           "another host is connected to this rig");
  send_frame(server, stream, lamella_v1_Reply_fields, &reply);
  door_dismiss(&server->door, stream, now_us());
}

static void turn_away_from_pairing(struct link_server* server, struct link_stream* stream) {
  lamella_v1_PairReply reply = {.which_body = lamella_v1_PairReply_refusal_tag};
  reply.body.refusal.code = lamella_v1_PairRefusal_Code_BUSY;
  snprintf(reply.body.refusal.reason, sizeof reply.body.refusal.reason,
           "another host is being paired with this rig");
  send_frame(server, stream, lamella_v1_PairReply_fields, &reply);
  door_dismiss(&server->door, stream, now_us());
}

// A guest whose handshake is over.
static void welcome(struct link_server* server, struct link_stream* stream,
                    const struct link_peer* peer) {
  if (peer->purpose == LINK_FOR_BURSTS) {
    if (server->host.socket >= 0) {
      turn_away(server, stream);
    } else {
      server->host = *stream;
      server->hello_by_us = now_us() + kHelloUs;
    }
  } else if (server->pairing.socket >= 0) {
    turn_away_from_pairing(server, stream);
  } else {
    server->pairing = *stream;
    pair_begin(&server->pair, peer, now_us());
  }
}

// Answers every whole message received so far. False where the host is to be left.
static bool answer_received(struct link_server* server) {
  size_t at = 0, length = 0;
  bool keep = true;
  while (keep && server->received_count - at >= WIRE_LENGTH_BYTES) {
    if (!wire_get_length(server->received + at, &length)) {
      link_refuse(&server->dialogue, 0, lamella_v1_Refusal_Code_BAD_REQUEST,
                  "a message is 1 to 65536 bytes long");
      return false;
    }
    if (server->received_count - at < WIRE_LENGTH_BYTES + length) break;
    keep = link_answer(&server->dialogue, server->received + at + WIRE_LENGTH_BYTES, length);
    at += WIRE_LENGTH_BYTES + length;
  }
  server->received_count -= at;
  memmove(server->received, server->received + at, server->received_count);
  return keep;
}

static void hear_host(struct link_server* server) {
  const size_t room = sizeof server->received - server->received_count;
  const int count =
      link_stream_read(&server->host, server->received + server->received_count, room);
  if (count > 0) server->received_count += (size_t)count;
  if (count < 0 || !answer_received(server)) lose_host(server);
}

static bool answer_pairing(struct link_server* server) {
  size_t length = 0;
  if (server->pair_received_count < WIRE_LENGTH_BYTES) return true;
  if (!wire_get_length(server->pair_received, &length)) return false;
  if (length > sizeof server->pair_received - WIRE_LENGTH_BYTES) return false;
  if (server->pair_received_count < WIRE_LENGTH_BYTES + length) return true;
  // Each request waits for its reply: what follows at once is not of this protocol.
  if (server->pair_received_count > WIRE_LENGTH_BYTES + length) return false;
  server->pair_received_count = 0;
  return pair_answer(&server->pair, server->pair_received + WIRE_LENGTH_BYTES, length, now_us());
}

static void hear_pairing(struct link_server* server) {
  const size_t room = sizeof server->pair_received - server->pair_received_count;
  const int count =
      room == 0 ? -1
                : link_stream_read(&server->pairing,
                                   server->pair_received + server->pair_received_count, room);
  if (count > 0) server->pair_received_count += (size_t)count;
  if (count < 0 || !answer_pairing(server)) end_pairing(server);
}

static void tick_pairing(struct link_server* server) {
  if (server->pairing.socket < 0) return;
  struct hal* hal = server->dialogue.session->hal;
  struct hal_senses senses = {.start_pressed = false};
  const bool pressed = hal->sense(hal->self, &senses) == LAM_OK && senses.start_pressed;
  server->pair.is_busy = session_is_busy(server->dialogue.session);
  if (!pair_tick(&server->pair, pressed, now_us())) end_pairing(server);
  show_code(server);
}

// A host that has not said hello yet: who comes meanwhile waits at the door, and is not told that
// the rig has a host.
static bool is_undecided(const struct link_server* server) {
  return server->host.socket >= 0 && !server->dialogue.greeted;
}

static void put_out_silent_host(struct link_server* server) {
  if (!is_undecided(server) || now_us() < server->hello_by_us) return;
  link_refuse(&server->dialogue, 0, lamella_v1_Refusal_Code_BAD_REQUEST,
              "a host says hello within 2 s");
  hang_up(server);
}

static void hear_guests(struct link_server* server) {
  for (int i = 0; i < DOOR_GUESTS; i++) {
    struct guest* guest = &server->door.guests[i];
    struct link_stream stream;
    struct link_peer peer;
    if (guest->stream.socket >= 0 && !is_undecided(server) &&
        door_shake(&server->door, guest, &stream, &peer) == LINK_DONE) {
      welcome(server, &stream, &peer);
    }
  }
  door_put_out(&server->door, now_us());
}

// Signals that are held elsewhere are let in: a wait for sockets takes none where one is ready, as
// that of a host is that never stops asking.
static void let_signals_in(void) {
  const struct timespec at_once = {0};
  sigset_t none_held;
  sigemptyset(&none_held);
  ppoll(NULL, 0, &at_once, &none_held);
}

// False where nobody spoke in time. SIGTERM and SIGINT end this wait, at once where they came
// earlier.
static bool listen_once(struct link_server* server, double timeout_us, double gap_us) {
  struct pollfd sockets[POLLED] = {{.fd = server->door.listener, .events = POLLIN},
                                   {.fd = server->host.socket, .events = POLLIN},
                                   {.fd = server->pairing.socket, .events = POLLIN}};
  for (int i = 0; i < DOOR_GUESTS; i++) {
    const int guest = is_undecided(server) ? -1 : server->door.guests[i].stream.socket;
    sockets[FIRST_GUEST + i] = (struct pollfd){.fd = guest, .events = POLLIN};
  }
  const bool more = server->host.socket >= 0 && link_stream_has_more(&server->host);
  const long long timeout_ns = more ? 0 : (long long)(timeout_us * 1e3);
  const struct timespec timeout = {timeout_ns / 1000000000, timeout_ns % 1000000000};
  sigset_t none_held;
  sigemptyset(&none_held);
  const int ready = ppoll(sockets, POLLED, &timeout, &none_held);
  if (ready < 0) return false;
  if (ready > 0) let_signals_in();
  if (more || sockets[HOST].revents != 0) hear_host(server);
  put_out_silent_host(server);
  if (sockets[LISTENER].revents != 0) door_accept(&server->door, now_us());
  if (server->door.context == NULL || gap_us >= kShakeGapUs) hear_guests(server);
  if (isinf(gap_us)) {  // nobody is paired while edges are played
    if (sockets[PAIRING].revents != 0) hear_pairing(server);
    tick_pairing(server);
  }
  return more || ready > 0;
}

// Tends to what is due, then hears hosts until it is due again. A simulated clock stands still
// while one listens, so it is moved on.
static void tend_and_listen(struct link_server* server, struct hal* hal, bool working,
                            double gap_us) {
  const double longest_us = server->pairing.socket >= 0 ? kPairPollUs : kLongestPollUs;
  const double due_us = server->tend != NULL ? server->tend(server->tend_context) : INFINITY;
  const double wait_us = due_us - hal->now_us(hal->self);
  const double timeout_us = working ? 0 : fmin(fmax(wait_us, 0), longest_us);
  if (listen_once(server, timeout_us, gap_us) || working || wait_us > longest_us) return;
  if (!hal->keeps_real_time) hal->wait_until_us(hal->self, due_us);
}

// Between two edges on a real clock. A host is heard where an answer fits many times.
static void rest_between_edges(struct link_server* server, struct session* session,
                               double slack_us) {
  const double rest_us = fmin(slack_us - kReadyUs, kWatchEveryUs);
  sigset_t none_held;
  sigemptyset(&none_held);
  if (slack_us >= kListenGapUs) {
    if (server->tend != NULL) server->tend(server->tend_context);
    listen_once(server, rest_us, slack_us);
  } else {
    const struct timespec rest = {.tv_nsec = (long)(rest_us * 1e3)};
    ppoll(NULL, 0, &rest, &none_held);
  }
  session_watch(session);
}

void link_serve(struct link_server* server, struct session* session, volatile sig_atomic_t* stop) {
  server->dialogue.session = session;
  server->dialogue.send = send_to_host;
  server->dialogue.send_chunk = send_chunk_to_host;
  server->dialogue.context = server;
  bool working = false;
  while (!*stop) {
    const double slack_us = session_slack_us(session);
    if (session->playing && session->hal->keeps_real_time && slack_us > kReadyUs) {
      rest_between_edges(server, session, slack_us);
    } else {
      if (slack_us >= kListenGapUs) {
        tend_and_listen(server, session->hal, working, slack_us);
        session_watch(session);
      }
      working = session_work(session);
    }
    if (session_slack_us(session) < kListenGapUs) continue;
    if (!link_tell_news(&server->dialogue)) lose_host(server);
  }
}
