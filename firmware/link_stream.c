#include "link_stream.h"

#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

const struct link_stream kNoStream = {.socket = -1};

// A peer that vanished without a word is noticed after some 7 s, so that it can come back.
static const int kIdleS = 4, kProbeEveryS = 1, kProbes = 3;
static const unsigned kUnheardMs = 7000;

// OpenSSL's own socket BIO would raise SIGPIPE; this one does not.
static int bio_write(BIO* bio, const char* bytes, int count) {
  BIO_clear_retry_flags(bio);
  const ssize_t sent =
      send((int)(intptr_t)BIO_get_data(bio), bytes, (size_t)count, MSG_NOSIGNAL | MSG_DONTWAIT);
  if (sent < 0 && (errno == EAGAIN || errno == EINTR)) BIO_set_retry_write(bio);
  return (int)sent;
}

static int bio_read(BIO* bio, char* bytes, int room) {
  BIO_clear_retry_flags(bio);
  const ssize_t got = recv((int)(intptr_t)BIO_get_data(bio), bytes, (size_t)room, MSG_DONTWAIT);
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) BIO_set_retry_read(bio);
  return (int)got;
}

static long bio_control(BIO* bio, int command, long number, void* data) {
  (void)bio, (void)number, (void)data;
  return command == BIO_CTRL_FLUSH;
}

static BIO* socket_bio(int socket) {
  static BIO_METHOD* method;
  if (method == NULL) {
    method = BIO_meth_new(BIO_get_new_index() | BIO_TYPE_SOURCE_SINK, "lamella link");
    BIO_meth_set_write(method, bio_write);
    BIO_meth_set_read(method, bio_read);
    BIO_meth_set_ctrl(method, bio_control);
  }
  BIO* bio = BIO_new(method);
  if (bio == NULL) return NULL;
  BIO_set_data(bio, (void*)(intptr_t)socket);
  BIO_set_init(bio, 1);
  return bio;
}

static void prepare_socket(int socket) {
  const int on = 1;
  fcntl(socket, F_SETFL, fcntl(socket, F_GETFL) | O_NONBLOCK);
  fcntl(socket, F_SETFD, FD_CLOEXEC);
  setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  setsockopt(socket, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
  setsockopt(socket, IPPROTO_TCP, TCP_KEEPIDLE, &kIdleS, sizeof kIdleS);
  setsockopt(socket, IPPROTO_TCP, TCP_KEEPINTVL, &kProbeEveryS, sizeof kProbeEveryS);
  setsockopt(socket, IPPROTO_TCP, TCP_KEEPCNT, &kProbes, sizeof kProbes);
  setsockopt(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, &kUnheardMs, sizeof kUnheardMs);
}

enum link_progress link_stream_open(struct link_stream* stream, int socket, SSL_CTX* context) {
  *stream = kNoStream;
  stream->socket = socket;
  prepare_socket(socket);
  if (context == NULL) return LINK_DONE;
  BIO* bio = socket_bio(socket);
  stream->tls = bio != NULL ? SSL_new(context) : NULL;
  if (stream->tls == NULL) {
    BIO_free(bio);
    link_stream_close(stream);
    return LINK_GONE;
  }
  SSL_set_bio(stream->tls, bio, bio);
  SSL_set_accept_state(stream->tls);
  return LINK_LATER;
}

void link_stream_close(struct link_stream* stream) {
  if (stream->tls != NULL) {
    ERR_clear_error();
    if (SSL_is_init_finished(stream->tls)) SSL_shutdown(stream->tls);  // sends, waits for nothing
    SSL_free(stream->tls);
  }
  if (stream->socket >= 0) close(stream->socket);
  stream->tls = NULL;
  stream->socket = -1;
}

// What an OpenSSL call that did not succeed came to; poll's events for what it waits for.
static enum link_progress judge(struct link_stream* stream, int result, short* events) {
  const int why = SSL_get_error(stream->tls, result);
  if (events != NULL) *events = why == SSL_ERROR_WANT_READ ? POLLIN : POLLOUT;
  if (why == SSL_ERROR_WANT_READ || why == SSL_ERROR_WANT_WRITE) return LINK_LATER;
  const char* reason = ERR_reason_error_string(ERR_peek_error());
  snprintf(stream->fate, sizeof stream->fate, "%s", reason != NULL ? reason : "connection closed");
  return LINK_GONE;
}

// OpenSSL closes on what is no TLS without a word. The alert tells whoever speaks in the clear what
// it has met.
static void alert_in_the_clear(int socket) {
  static const uint8_t kProtocolVersionAlert[] = {21, 3, 3, 0, 2, 2, 70};
  send(socket, kProtocolVersionAlert, sizeof kProtocolVersionAlert, MSG_NOSIGNAL | MSG_DONTWAIT);
}

static enum link_progress await_first_byte(struct link_stream* stream) {
  uint8_t first;
  const ssize_t got = recv(stream->socket, &first, 1, MSG_PEEK | MSG_DONTWAIT);
  if (got > 0) return LINK_DONE;
  if (got < 0 && (errno == EINTR || errno == EAGAIN)) return LINK_LATER;
  snprintf(stream->fate, sizeof stream->fate, "closed without a word");
  return LINK_GONE;
}

enum link_progress link_stream_shake(struct link_stream* stream) {
  if (stream->tls == NULL) return await_first_byte(stream);
  ERR_clear_error();
  const int result = SSL_do_handshake(stream->tls);
  if (result == 1) return LINK_DONE;
  const enum link_progress progress = judge(stream, result, NULL);
  const bool greeted = SSL_get_state(stream->tls) != TLS_ST_BEFORE;
  if (progress == LINK_GONE && !greeted) alert_in_the_clear(stream->socket);
  return progress;
}

int link_stream_read(struct link_stream* stream, uint8_t* bytes, size_t room) {
  if (stream->tls == NULL) {
    const ssize_t count = recv(stream->socket, bytes, room, MSG_DONTWAIT);
    if (count < 0 && (errno == EINTR || errno == EAGAIN)) return 0;
    return count > 0 ? (int)count : -1;
  }
  ERR_clear_error();
  const int count = SSL_read(stream->tls, bytes, (int)room);
  if (count > 0) return count;
  return judge(stream, count, NULL) == LINK_LATER ? 0 : -1;
}

bool link_stream_has_more(const struct link_stream* stream) {
  return stream->tls != NULL && SSL_has_pending(stream->tls);
}

static int64_t now_ms(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * INT64_C(1000) + now.tv_nsec / 1000000;
}

// Bytes written, 0 where there is no room now, -1 where the other end is gone.
static int write_some(struct link_stream* stream, const uint8_t* bytes, size_t count,
                      short* events) {
  *events = POLLOUT;
  if (stream->tls == NULL) {
    const ssize_t sent = send(stream->socket, bytes, count, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && (errno == EINTR || errno == EAGAIN)) return 0;
    return sent > 0 ? (int)sent : -1;
  }
  ERR_clear_error();
  const int sent = SSL_write(stream->tls, bytes, (int)count);
  if (sent > 0) return sent;
  return judge(stream, sent, events) == LINK_LATER ? 0 : -1;
}

bool link_stream_write(struct link_stream* stream, const uint8_t* bytes, size_t count,
                       int patience_ms) {
  const int64_t end_ms = now_ms() + patience_ms;
  while (count > 0) {
    struct pollfd wait = {.fd = stream->socket};
    const int sent = write_some(stream, bytes, count, &wait.events);
    if (sent < 0) return false;
    bytes += sent;
    count -= (size_t)sent;
    if (sent > 0) continue;
    const int64_t left_ms = end_ms - now_ms();
    if (left_ms <= 0) return false;
    poll(&wait, 1, (int)left_ms);  // a signal: the time is looked at again
  }
  return true;
}
