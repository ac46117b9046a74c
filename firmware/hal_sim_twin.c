#include "hal_sim_twin.h"

#include <errno.h>
#include <pb_decode.h>
#include <pb_encode.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "crc32c.h"
#include "wire.h"

enum { kPhotographTimeoutMs = 120000, kLookMs = 100 };

int sim_twin_connect(const char* path, char* error, size_t error_size) {
  struct sockaddr_un address = {.sun_family = AF_UNIX};
  if (strlen(path) >= sizeof address.sun_path) {
    snprintf(error, error_size, "--twin: the path is longer than a socket's name may be");
    return -1;
  }
  strcpy(address.sun_path, path);
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0 || connect(fd, (struct sockaddr*)&address, sizeof address) != 0) {
    snprintf(error, error_size, "no twin answers on %.60s: %s; start `lamella twin --serve`", path,
             strerror(errno));
    if (fd >= 0) close(fd);
    return -1;
  }
  return fd;
}

void sim_twin_disconnect(int socket) {
  if (socket < 0) return;
  shutdown(socket, SHUT_RDWR);  // whoever still waits for a photograph stops
  close(socket);
}

static bool send_all(int socket, const uint8_t* bytes, size_t count) {
  while (count > 0) {
    const ssize_t sent = send(socket, bytes, count, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    bytes += sent;
    count -= (size_t)sent;
  }
  return true;
}

// The daemon holds signals back until it has time for them (main.c).
static bool is_to_stop(void) {
  sigset_t held;
  return sigpending(&held) == 0 &&
         (sigismember(&held, SIGTERM) == 1 || sigismember(&held, SIGINT) == 1 ||
          sigismember(&held, SIGHUP) == 1);
}

// A signal or a twin silent for too long ends the wait: the daemon must stay stoppable.
static bool await_bytes(int socket) {
  struct pollfd wait = {.fd = socket, .events = POLLIN};
  for (int waited_ms = 0; waited_ms < kPhotographTimeoutMs; waited_ms += kLookMs) {
    const int ready = poll(&wait, 1, kLookMs);
    if (ready != 0) return ready > 0;
    if (is_to_stop()) return false;
  }
  return false;
}

static bool receive_all(int socket, uint8_t* bytes, size_t count) {
  while (count > 0) {
    if (!await_bytes(socket)) return false;
    const ssize_t received = recv(socket, bytes, count, 0);
    if (received <= 0) return false;
    bytes += received;
    count -= (size_t)received;
  }
  return true;
}

static bool send_report(int socket, const lamella_v1_ExposureReport* report) {
  static uint8_t message[WIRE_LENGTH_BYTES + lamella_v1_ExposureReport_size];
  pb_ostream_t stream =
      pb_ostream_from_buffer(message + WIRE_LENGTH_BYTES, lamella_v1_ExposureReport_size);
  if (!pb_encode(&stream, lamella_v1_ExposureReport_fields, report)) return false;
  wire_put_length(message, stream.bytes_written);
  return send_all(socket, message, WIRE_LENGTH_BYTES + stream.bytes_written);
}

static bool receive_header(int socket, lamella_v1_PhotographHeader* header) {
  uint8_t prefix[WIRE_LENGTH_BYTES];
  uint8_t message[lamella_v1_PhotographHeader_size + 256];  // fields of a newer twin are skipped
  size_t length = 0;
  if (!receive_all(socket, prefix, sizeof prefix) || !wire_get_length(prefix, &length) ||
      length > sizeof message || !receive_all(socket, message, length)) {
    return false;
  }
  pb_istream_t stream = pb_istream_from_buffer(message, length);
  return pb_decode(&stream, lamella_v1_PhotographHeader_fields, header);
}

bool sim_twin_photograph(int socket, const lamella_v1_ExposureReport* report,
                         struct hal_photograph* photograph) {
  char* error = photograph->error;
  const size_t error_size = sizeof photograph->error;
  lamella_v1_PhotographHeader* header = &photograph->header;
  if (!send_report(socket, report) || !receive_header(socket, header)) {
    snprintf(error, error_size, "the twin fell silent, or what came was no photograph header");
    return false;
  }
  if (header->error[0] != '\0') {
    snprintf(error, error_size, "the twin says: %s", header->error);
    return false;
  }
  if (header->size_bytes > photograph->capacity) {
    snprintf(error, error_size,
             "a photograph of %u bytes, room for %zu: raise "
             "store.capacity_bytes",
             (unsigned)header->size_bytes, photograph->capacity);
    return false;
  }
  if (!receive_all(socket, photograph->bytes, header->size_bytes)) {
    snprintf(error, error_size, "the twin fell silent in the middle of a photograph");
    return false;
  }
  if (crc32c_extend(0, photograph->bytes, header->size_bytes) != header->crc32c) {
    snprintf(error, error_size, "a photograph of the twin does not match its checksum");
    return false;
  }
  return true;
}
