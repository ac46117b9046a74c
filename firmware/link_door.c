#include "link_door.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <openssl/ssl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "complain.h"

static const double kShakeUs = 8e6;  // a burst in between may take most of it

// What is wrong with it, or NULL.
static const char* parse_address(const char* text, struct sockaddr_in* address) {
  char host[16] = "";
  const char* colon = strrchr(text, ':');
  if (colon == NULL) return "no port: give ADDRESS:PORT";
  char* end = NULL;
  const unsigned long port = strtoul(colon + 1, &end, 10);
  const bool digit = colon[1] >= '0' && colon[1] <= '9';
  if (!digit || *end != '\0' || port > 65535) {
    return "a port is a number from 0 to 65535, 0 for any that is free";
  }
  if ((size_t)(colon - text) < sizeof host) memcpy(host, text, (size_t)(colon - text));
  *address = (struct sockaddr_in){.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
  const bool numbers = inet_pton(AF_INET, host, &address->sin_addr) == 1;
  return numbers ? NULL : "not an IPv4 address in numbers before the port";
}

static enum lam_status bind_listener(struct link_door* door, const char* address,
                                     struct sockaddr_in* bound, char* error, size_t error_size) {
  door->listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int on = 1;
  setsockopt(door->listener, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  socklen_t size = sizeof *bound;
  if (door->listener < 0 || bind(door->listener, (struct sockaddr*)bound, size) != 0 ||
      listen(door->listener, 8) != 0 ||
      getsockname(door->listener, (struct sockaddr*)bound, &size) != 0) {
    snprintf(error, error_size, "--listen %s: %s", address, strerror(errno));
    return LAM_HARDWARE;
  }
  door->port = ntohs(bound->sin_port);
  inet_ntop(AF_INET, &bound->sin_addr, door->address, sizeof door->address);
  return LAM_OK;
}

// Nobody else may put a file where keys and trusted hosts are read from.
static enum lam_status check_folder(const char* folder, char* error, size_t error_size) {
  struct stat state;
  if (stat(folder, &state) != 0 || !S_ISDIR(state.st_mode)) {
    snprintf(error, error_size, "--state %s: no such folder: make one of mode 0700", folder);
    return LAM_BAD_INPUT;
  }
  if ((state.st_mode & 022) == 0) return LAM_OK;
  snprintf(error, error_size, "--state %s: others may write into it: chmod 700", folder);
  return LAM_BAD_INPUT;
}

static enum lam_status open_tls(struct link_door* door, const char* folder, char* error,
                                size_t error_size) {
  enum lam_status status = check_folder(folder, error, error_size);
  if (status == LAM_OK) status = identity_open(&door->identity, folder, error, error_size);
  if (status == LAM_OK) status = trust_open(&door->trust, folder, error, error_size);
  if (status != LAM_OK) return status;
  door->context = link_tls_context(&door->identity, &door->trust);
  if (door->context != NULL) return LAM_OK;
  snprintf(error, error_size, "--state %s: OpenSSL cannot use this key", folder);
  return LAM_BAD_INPUT;
}

enum lam_status door_open(struct link_door* door, const struct link_place* place, char* error,
                          size_t error_size) {
  memset(door, 0, sizeof *door);
  door->listener = -1;
  for (int i = 0; i < DOOR_GUESTS; i++) door->guests[i].stream = kNoStream;
  struct sockaddr_in bound;
  const char* why = parse_address(place->address, &bound);
  if (why != NULL) {
    snprintf(error, error_size, "--listen %s: %s", place->address, why);
    return LAM_BAD_INPUT;
  }
  if (place->state == NULL && ntohl(bound.sin_addr.s_addr) >> 24 != 127) {
    snprintf(error, error_size,
             "--listen %s: only loopback (127.0.0.1:PORT) without TLS; give --state FOLDER for "
             "TLS with paired hosts",
             place->address);
    return LAM_BAD_INPUT;
  }
  enum lam_status status = LAM_OK;
  if (place->state != NULL) status = open_tls(door, place->state, error, error_size);
  if (status == LAM_OK) status = bind_listener(door, place->address, &bound, error, error_size);
  if (status != LAM_OK) door_close(door);
  return status;
}

void door_close(struct link_door* door) {
  for (int i = 0; i < DOOR_GUESTS; i++) link_stream_close(&door->guests[i].stream);
  if (door->listener >= 0) close(door->listener);
  door->listener = -1;
  SSL_CTX_free(door->context);
  door->context = NULL;
  identity_close(&door->identity);
}

// A free place, else the one that has been taken for longest.
static struct guest* place_for_one_more(struct link_door* door) {
  struct guest* oldest = &door->guests[0];
  for (int i = 0; i < DOOR_GUESTS; i++) {
    struct guest* guest = &door->guests[i];
    if (guest->stream.socket < 0) return guest;
    if (guest->ends_us < oldest->ends_us) oldest = guest;
  }
  link_stream_close(&oldest->stream);
  return oldest;
}

void door_accept(struct link_door* door, double now_us) {
  const int socket = accept(door->listener, NULL, NULL);
  if (socket < 0) return;
  struct guest* guest = place_for_one_more(door);
  guest->ends_us = now_us + kShakeUs;
  guest->refused = false;
  link_stream_open(&guest->stream, socket, door->context);
}

static void hold_out(struct guest* guest) {
  shutdown(guest->stream.socket, SHUT_WR);
  guest->refused = true;
}

void door_dismiss(struct link_door* door, const struct link_stream* stream, double now_us) {
  struct guest* guest = place_for_one_more(door);
  guest->stream = *stream;
  guest->ends_us = now_us + kShakeUs;
  hold_out(guest);
}

static bool know_guest(const struct link_door* door, const struct guest* guest,
                       struct link_peer* peer) {
  if (door->context != NULL) return link_tls_peer(&guest->stream, peer);
  *peer = (struct link_peer){.purpose = LINK_FOR_BURSTS};
  return true;
}

static void refuse(struct guest* guest) {
  complain("lamella-rigd: a connection was refused: %s", guest->stream.fate);
  hold_out(guest);
}

static enum link_progress hear_out(struct guest* guest) {
  uint8_t ignored[1024];
  const ssize_t got = recv(guest->stream.socket, ignored, sizeof ignored, MSG_DONTWAIT);
  if (got > 0 || (got < 0 && (errno == EAGAIN || errno == EINTR))) return LINK_LATER;
  link_stream_close(&guest->stream);
  return LINK_GONE;
}

enum link_progress door_shake(struct link_door* door, struct guest* guest,
                              struct link_stream* stream, struct link_peer* peer) {
  if (guest->refused) return hear_out(guest);
  enum link_progress progress = link_stream_shake(&guest->stream);
  if (progress == LINK_LATER) return progress;
  if (progress == LINK_DONE && !know_guest(door, guest, peer)) progress = LINK_GONE;
  if (progress == LINK_GONE) {
    refuse(guest);
    return hear_out(guest);
  }
  *stream = guest->stream;
  guest->stream = kNoStream;
  return LINK_DONE;
}

void door_put_out(struct link_door* door, double now_us) {
  for (int i = 0; i < DOOR_GUESTS; i++) {
    struct guest* guest = &door->guests[i];
    if (guest->stream.socket >= 0 && now_us > guest->ends_us) link_stream_close(&guest->stream);
  }
}
