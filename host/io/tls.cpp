#include "io/tls.h"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstring>

#include "base/error.h"

namespace lamella {

namespace {

constexpr char kExporterLabel[] = "EXPORTER-lamella-link";
constexpr long kMaxCertificateBytes = 4096;

}  // namespace

// What OpenSSL reads and writes. It asks for the head of a record, then for the rest of it: what
// comes behind is had in the same call to the kernel, and kept. (OpenSSL's own read-ahead moves all
// that it has read ahead to the front of its buffer for every record.)
struct Tls::Line {
  int fd;
  std::array<char, 64 << 10> ahead;
  size_t begin = 0, end = 0;  // of what is kept
};

namespace {

int give_kept(Tls::Line* line, char* bytes, int room) {
  const size_t count = std::min(line->end - line->begin, size_t(room));
  std::memcpy(bytes, line->ahead.data() + line->begin, count);
  line->begin += count;
  return int(count);
}

// OpenSSL's own socket BIO would raise SIGPIPE; this one does not.
int bio_write(BIO* bio, const char* bytes, int count) {
  BIO_clear_retry_flags(bio);
  const auto* line = static_cast<Tls::Line*>(BIO_get_data(bio));
  const ssize_t sent = send(line->fd, bytes, size_t(count), MSG_NOSIGNAL);
  if (sent < 0 && (errno == EAGAIN || errno == EINTR)) BIO_set_retry_write(bio);
  return int(sent);
}

int bio_read(BIO* bio, char* bytes, int room) {
  BIO_clear_retry_flags(bio);
  auto* line = static_cast<Tls::Line*>(BIO_get_data(bio));
  if (line->begin < line->end) return give_kept(line, bytes, room);
  const iovec parts[] = {{bytes, size_t(room)}, {line->ahead.data(), line->ahead.size()}};
  const ssize_t got = readv(line->fd, parts, 2);
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) BIO_set_retry_read(bio);
  line->begin = 0;
  line->end = got > room ? size_t(got) - size_t(room) : 0;
  return int(std::min<ssize_t>(got, room));
}

long bio_control(BIO*, int command, long, void*) { return command == BIO_CTRL_FLUSH; }

BIO_METHOD* socket_method() {
  static BIO_METHOD* const method = [] {
    BIO_METHOD* made = BIO_meth_new(BIO_get_new_index() | BIO_TYPE_SOURCE_SINK, "lamella link");
    BIO_meth_set_write(made, bio_write);
    BIO_meth_set_read(made, bio_read);
    BIO_meth_set_ctrl(made, bio_control);
    return made;
  }();
  return method;
}

bool set_up(SSL_CTX* context, const TlsOptions& options) {
  SSL_CTX_set_options(context, SSL_OP_NO_TICKET | SSL_OP_NO_COMPRESSION | SSL_OP_NO_RENEGOTIATION);
  SSL_CTX_set_session_cache_mode(context, SSL_SESS_CACHE_OFF);
  SSL_CTX_set_max_cert_list(context, kMaxCertificateBytes);
  SSL_CTX_set_mode(context, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  const std::string alpn = char(options.protocol.size()) + options.protocol;
  return SSL_CTX_set_min_proto_version(context, TLS1_3_VERSION) == 1 &&
         SSL_CTX_set_max_proto_version(context, TLS1_3_VERSION) == 1 &&
         SSL_CTX_set_ciphersuites(context, "TLS_AES_128_GCM_SHA256:TLS_CHACHA20_POLY1305_SHA256") ==
             1 &&
         SSL_CTX_set1_groups_list(context, "X25519:P-256") == 1 &&
         SSL_CTX_set_alpn_protos(context, reinterpret_cast<const unsigned char*>(alpn.data()),
                                 unsigned(alpn.size())) == 0 &&
         SSL_CTX_use_certificate(context, options.identity->certificate()) == 1 &&
         SSL_CTX_use_PrivateKey(context, options.identity->key()) == 1;
}

}  // namespace

void Tls::Free::operator()(SSL_CTX* context) const { SSL_CTX_free(context); }
void Tls::Free::operator()(SSL* tls) const { SSL_free(tls); }

Tls::Tls(int fd, TlsOptions options)
    : options_(std::move(options)),
      line_(new Line{.fd = fd, .ahead = {}}),
      context_(SSL_CTX_new(TLS_client_method())) {
  if (!context_ || !set_up(context_.get(), options_)) {
    throw Error(Fault::kRig, "TLS", "OpenSSL cannot be set up");
  }
  SSL_CTX_set_verify(context_.get(), SSL_VERIFY_PEER, nullptr);
  SSL_CTX_set_cert_verify_callback(context_.get(), &Tls::verify, this);
  tls_.reset(SSL_new(context_.get()));
  BIO* bio = BIO_new(socket_method());
  if (!tls_ || !bio) throw Error(Fault::kRig, "TLS", "OpenSSL has no memory");
  BIO_set_data(bio, line_.get());
  BIO_set_init(bio, 1);
  SSL_set_bio(tls_.get(), bio, bio);
  SSL_set_connect_state(tls_.get());
}

Tls::~Tls() {
  ERR_clear_error();
  if (SSL_is_init_finished(tls_.get())) SSL_shutdown(tls_.get());  // says so, waits for nothing
}

// In place of chains and authorities. That the peer holds the key, TLS itself proves.
int Tls::verify(X509_STORE_CTX* store, void* argument) {
  Tls* self = static_cast<Tls*>(argument);
  const X509* certificate = X509_STORE_CTX_get0_cert(store);
  const auto fingerprint = certificate ? fingerprint_of(certificate) : std::nullopt;
  if (fingerprint && self->options_.accepts(*fingerprint)) {
    self->peer_ = *fingerprint;
    return 1;
  }
  self->refused_peer_ = true;
  X509_STORE_CTX_set_error(store, X509_V_ERR_CERT_REJECTED);
  return 0;
}

Tls::Progress Tls::judge(int result) {
  switch (SSL_get_error(tls_.get(), result)) {
    case SSL_ERROR_WANT_READ:
      return Progress::kWantsRead;
    case SSL_ERROR_WANT_WRITE:
      return Progress::kWantsWrite;
    default:
      break;
  }
  const unsigned long error = ERR_peek_error();
  const char* words = error ? ERR_reason_error_string(error) : nullptr;
  reason_ = words ? words : "connection closed";
  // In the words of what it means here.
  const int reason = error ? ERR_GET_REASON(error) : 0;
  if (reason == SSL_R_SSLV3_ALERT_BAD_CERTIFICATE) reason_ = kNotPaired;
  if (reason == SSL_R_WRONG_VERSION_NUMBER) reason_ = kAnswersInTheClear;
  if (refused_peer_) reason_ = kAnotherKey;
  return Progress::kClosed;
}

Tls::Progress Tls::shake_hands() {
  ERR_clear_error();
  const int result = SSL_do_handshake(tls_.get());
  if (result != 1) return judge(result);
  const unsigned char* protocol = nullptr;
  unsigned length = 0;
  SSL_get0_alpn_selected(tls_.get(), &protocol, &length);
  if (std::string(reinterpret_cast<const char*>(protocol), length) == options_.protocol) {
    return Progress::kDone;
  }
  reason_ = "speaks TLS, but not as a rig";
  return Progress::kClosed;
}

Tls::Progress Tls::write(const uint8_t* bytes, size_t size, size_t* done) {
  ERR_clear_error();
  *done = 0;
  const int result = SSL_write(tls_.get(), bytes, int(std::min<size_t>(size, INT_MAX)));
  if (result <= 0) return judge(result);
  *done = size_t(result);
  return Progress::kDone;
}

Tls::Progress Tls::read(uint8_t* bytes, size_t room, size_t* done) {
  ERR_clear_error();
  *done = 0;
  const int result = SSL_read(tls_.get(), bytes, int(std::min<size_t>(room, INT_MAX)));
  if (result <= 0) return judge(result);
  *done = size_t(result);
  return Progress::kDone;
}

std::array<uint8_t, 32> Tls::channel() const {
  std::array<uint8_t, 32> key{};
  if (SSL_export_keying_material(tls_.get(), key.data(), key.size(), kExporterLabel,
                                 std::strlen(kExporterLabel), nullptr, 0, 0) != 1) {
    throw Error(Fault::kRig, "TLS", "no key for this channel");
  }
  return key;
}

}  // namespace lamella
