#define _GNU_SOURCE
#include "link.h"

#include <arpa/inet.h>
#include <errno.h>
#include <math.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <pb_encode.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

// While edges are played the link is heard only in gaps this long: a short answer fits many times.
static const double kListenGapUs = 5000;
static const double kLongestPollUs = 200000;
// On a real clock the loop sleeps until this long before an edge, and looks at the rig this often.
static const double kReadyUs = 1000;
static const double kWatchEveryUs = 2000;
static const time_t kSendTimeoutS = 5;

static bool parse_address(const char* text, struct sockaddr_in* address) {
  char host[16];
  const char* colon = strrchr(text, ':');
  if (colon == NULL || (size_t)(colon - text) >= sizeof host) return false;
  memcpy(host, text, (size_t)(colon - text));
  host[colon - text] = '\0';
  char* end = NULL;
  const unsigned long port = strtoul(colon + 1, &end, 10);
  if (end == colon + 1 || *end != '\0' || port > 65535) return false;
  *address = (struct sockaddr_in){.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
  return inet_pton(AF_INET, host, &address->sin_addr) == 1;
}

enum lam_status link_listen(struct link_server* server, const char* address, char* error,
                            size_t error_size) {
  memset(server, 0, sizeof *server);
  server->listener = server->host = -1;
  struct sockaddr_in bound;
  if (!parse_address(address, &bound)) {
    snprintf(error, error_size, "--listen %s: not ADDRESS:PORT; use 127.0.0.1:0", address);
    return LAM_BAD_INPUT;
  }
  if (ntohl(bound.sin_addr.s_addr) >> 24 != 127) {
    snprintf(error, error_size,
             "--listen %s: only loopback (127.0.0.1:PORT) until hosts can be "
             "paired with the rig",
             address);
    return LAM_BAD_INPUT;
  }
  server->listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int on = 1;
  setsockopt(server->listener, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  socklen_t size = sizeof bound;
  if (server->listener < 0 || bind(server->listener, (struct sockaddr*)&bound, size) != 0 ||
      listen(server->listener, 4) != 0 ||
      getsockname(server->listener, (struct sockaddr*)&bound, &size) != 0) {
    snprintf(error, error_size, "--listen %s: %s", address, strerror(errno));
    link_close(server);
    return LAM_HARDWARE;
  }
  server->port = ntohs(bound.sin_port);
  return LAM_OK;
}

static void hang_up(struct link_server* server) {
  if (server->host >= 0) close(server->host);
  server->host = -1;
  server->received_count = 0;
  server->dialogue.greeted = false;
}

void link_close(struct link_server* server) {
  hang_up(server);
  if (server->listener >= 0) close(server->listener);
  server->listener = -1;
}

static bool send_frame(int socket, uint8_t* frame, const lamella_v1_Reply* reply) {
  pb_ostream_t stream = pb_ostream_from_buffer(frame + WIRE_LENGTH_BYTES, WIRE_MAX_MESSAGE_BYTES);
  if (!pb_encode(&stream, lamella_v1_Reply_fields, reply)) return false;
  wire_put_length(frame, stream.bytes_written);
  const uint8_t* bytes = frame;
  for (size_t left = WIRE_LENGTH_BYTES + stream.bytes_written; left > 0;) {
    const ssize_t sent = send(socket, bytes, left, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    bytes += sent;
    left -= (size_t)sent;
  }
  return true;
}

static bool send_to_host(void* context, const lamella_v1_Reply* reply) {
  struct link_server* server = context;
  return server->host >= 0 && send_frame(server->host, server->outgoing, reply);
}

static void prepare_socket(int socket) {
  const struct timeval timeout = {.tv_sec = kSendTimeoutS};
  const int on = 1;
  setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &timeout, sizeof timeout);
  setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  setsockopt(socket, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
}

// A second host is told so and left.
static void turn_away(struct link_server* server, int socket) {
  static lamella_v1_Reply reply;
  reply = (lamella_v1_Reply)lamella_v1_Reply_init_zero;
  reply.which_body = lamella_v1_Reply_refusal_tag;
  reply.body.refusal.code = lamella_v1_Refusal_Code_WRONG_STATE;
  snprintf(reply.body.refusal.reason, sizeof reply.body.refusal.reason,
           "another host is connected to this rig");
  send_frame(socket, server->outgoing, &reply);
  close(socket);
}

static void welcome(struct link_server* server) {
  const int socket = accept(server->listener, NULL, NULL);
  if (socket < 0) return;
  prepare_socket(socket);
  if (server->host >= 0) {
    turn_away(server, socket);
  } else {
    server->host = socket;
  }
}

// Answers every whole message received so far. False where the host is to be left.
static bool answer_received(struct link_server* server) {
  while (server->received_count >= WIRE_LENGTH_BYTES) {
    size_t length = 0;
    if (!wire_get_length(server->received, &length)) {
      link_refuse(&server->dialogue, 0, lamella_v1_Refusal_Code_BAD_REQUEST,
                  "a message is 1 to 65536 bytes long");
      return false;
    }
    const size_t whole = WIRE_LENGTH_BYTES + length;
    if (server->received_count < whole) return true;
    if (!link_answer(&server->dialogue, server->received + WIRE_LENGTH_BYTES, length)) return false;
    server->received_count -= whole;
    memmove(server->received, server->received + whole, server->received_count);
  }
  return true;
}

static void hear(struct link_server* server) {
  const size_t room = sizeof server->received - server->received_count;
  const ssize_t count =
      recv(server->host, server->received + server->received_count, room, MSG_DONTWAIT);
  if (count < 0 && (errno == EINTR || errno == EAGAIN)) return;
  if (count > 0) server->received_count += (size_t)count;
  if (count <= 0 || !answer_received(server)) hang_up(server);
}

// False where nobody spoke in time. SIGTERM and SIGINT, which are held elsewhere, are let in here
// alone: one that came earlier ends this wait at once.
static bool listen_once(struct link_server* server, double timeout_us) {
  struct pollfd sockets[2] = {{.fd = server->listener, .events = POLLIN},
                              {.fd = server->host, .events = POLLIN}};
  const long long timeout_ns = (long long)(timeout_us * 1e3);
  const struct timespec timeout = {timeout_ns / 1000000000, timeout_ns % 1000000000};
  sigset_t none_held;
  sigemptyset(&none_held);
  if (ppoll(sockets, 2, &timeout, &none_held) <= 0) return false;
  if (sockets[1].revents != 0) hear(server);
  if (sockets[0].revents != 0) welcome(server);
  return true;
}

// Tends to what is due, then hears hosts until it is due again. A simulated clock stands still
// while one listens, so it is moved on.
static void tend_and_listen(struct link_server* server, struct hal* hal, bool working) {
  const double due_us = server->tend != NULL ? server->tend(server->tend_context) : INFINITY;
  const double wait_us = due_us - hal->now_us(hal->self);
  const double timeout_us = working ? 0 : fmin(fmax(wait_us, 0), kLongestPollUs);
  if (listen_once(server, timeout_us) || working || wait_us > kLongestPollUs) return;
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
    listen_once(server, rest_us);
  } else {
    const struct timespec rest = {.tv_nsec = (long)(rest_us * 1e3)};
    ppoll(NULL, 0, &rest, &none_held);
  }
  session_watch(session);
}

void link_serve(struct link_server* server, struct session* session, volatile sig_atomic_t* stop) {
  server->dialogue.session = session;
  server->dialogue.send = send_to_host;
  server->dialogue.context = server;
  bool working = false;
  while (!*stop) {
    const double slack_us = session_slack_us(session);
    if (session->playing && session->hal->keeps_real_time && slack_us > kReadyUs) {
      rest_between_edges(server, session, slack_us);
    } else {
      if (slack_us >= kListenGapUs) {
        tend_and_listen(server, session->hal, working);
        session_watch(session);
      }
      working = session_work(session);
    }
    if (!link_tell_news(&server->dialogue)) hang_up(server);
  }
}
