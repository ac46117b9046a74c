#include "link_tls.h"

#include <openssl/ssl.h>
#include <string.h>
#if defined(__aarch64__)
#include <sys/auxv.h>
#endif

static const char kBurstProtocol[] = "lamella/1", kPairProtocol[] = "lamella-pair/1";
static const char kExporterLabel[] = "EXPORTER-lamella-link";
static const long kMaxCertificateBytes = 4096;

// AES where the processor has it (a Raspberry Pi 4's has not: there ChaCha20 is five times as
// fast).
static const char* cipher_suites(void) {
#if defined(__aarch64__)
  const unsigned long kHasAes = 1 << 3;  // HWCAP_AES
  if ((getauxval(AT_HWCAP) & kHasAes) == 0) {
    return "TLS_CHACHA20_POLY1305_SHA256:TLS_AES_128_GCM_SHA256";
  }
#endif
  return "TLS_AES_128_GCM_SHA256:TLS_CHACHA20_POLY1305_SHA256";
}

static bool is_protocol(const char* name, const unsigned char* protocol, size_t length) {
  return length == strlen(name) && memcmp(protocol, name, length) == 0;
}

static enum link_purpose purpose_of(const SSL* tls) {
  const unsigned char* protocol = NULL;
  unsigned length = 0;
  SSL_get0_alpn_selected(tls, &protocol, &length);
  if (is_protocol(kBurstProtocol, protocol, length)) return LINK_FOR_BURSTS;
  return is_protocol(kPairProtocol, protocol, length) ? LINK_FOR_PAIRING : LINK_FOR_NOTHING;
}

// The first protocol offered that is one of ours. `offered` is well-formed: OpenSSL has checked.
static int choose_protocol(SSL* tls, const unsigned char** chosen, unsigned char* chosen_length,
                           const unsigned char* offered, unsigned offered_length, void* none) {
  (void)tls, (void)none;
  for (unsigned at = 0; at < offered_length; at += 1u + offered[at]) {
    const unsigned char* name = offered + at + 1;
    if (!is_protocol(kBurstProtocol, name, offered[at]) &&
        !is_protocol(kPairProtocol, name, offered[at])) {
      continue;
    }
    *chosen = name;
    *chosen_length = offered[at];
    return SSL_TLSEXT_ERR_OK;
  }
  return SSL_TLSEXT_ERR_ALERT_FATAL;
}

// In place of chains and authorities. That the peer holds the certificate's key, TLS itself proves.
static int is_let_in(X509_STORE_CTX* store, void* argument) {
  const struct trust* trust = argument;
  const SSL* tls = X509_STORE_CTX_get_ex_data(store, SSL_get_ex_data_X509_STORE_CTX_idx());
  const X509* certificate = X509_STORE_CTX_get0_cert(store);
  uint8_t fingerprint[FINGERPRINT_BYTES];
  const bool has_key = certificate != NULL && identity_fingerprint(certificate, fingerprint);
  const enum link_purpose purpose = purpose_of(tls);
  if (has_key && purpose == LINK_FOR_PAIRING) return 1;
  if (has_key && purpose == LINK_FOR_BURSTS && trust_knows(trust, fingerprint)) return 1;
  X509_STORE_CTX_set_error(store, X509_V_ERR_CERT_REJECTED);
  return 0;
}

static bool set_limits(SSL_CTX* context) {
  SSL_CTX_set_options(context, SSL_OP_NO_TICKET | SSL_OP_CIPHER_SERVER_PREFERENCE |
                                   SSL_OP_NO_COMPRESSION | SSL_OP_NO_RENEGOTIATION);
  SSL_CTX_set_session_cache_mode(context, SSL_SESS_CACHE_OFF);
  SSL_CTX_set_max_cert_list(context, kMaxCertificateBytes);
  SSL_CTX_set_mode(context, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  return SSL_CTX_set_min_proto_version(context, TLS1_3_VERSION) == 1 &&
         SSL_CTX_set_max_proto_version(context, TLS1_3_VERSION) == 1 &&
         SSL_CTX_set_ciphersuites(context, cipher_suites()) == 1 &&
         SSL_CTX_set1_groups_list(context, "X25519:P-256") == 1 &&
         SSL_CTX_set_num_tickets(context, 0) == 1 && SSL_CTX_set_max_early_data(context, 0) == 1 &&
         SSL_CTX_set_recv_max_early_data(context, 0) == 1;
}

SSL_CTX* link_tls_context(const struct identity* identity, const struct trust* trust) {
  SSL_CTX* context = SSL_CTX_new(TLS_server_method());
  if (context == NULL) return NULL;
  if (!set_limits(context) || SSL_CTX_use_certificate(context, identity->certificate) != 1 ||
      SSL_CTX_use_PrivateKey(context, identity->key) != 1) {
    SSL_CTX_free(context);
    return NULL;
  }
  SSL_CTX_set_alpn_select_cb(context, choose_protocol, NULL);
  SSL_CTX_set_verify(context, SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT, NULL);
  SSL_CTX_set_cert_verify_callback(context, is_let_in, (void*)trust);
  return context;
}

bool link_tls_peer(const struct link_stream* stream, struct link_peer* peer) {
  if (stream->tls == NULL) return false;
  const X509* certificate = SSL_get0_peer_certificate(stream->tls);
  peer->purpose = purpose_of(stream->tls);
  return certificate != NULL && peer->purpose != LINK_FOR_NOTHING &&
         identity_fingerprint(certificate, peer->fingerprint) &&
         SSL_export_keying_material(stream->tls, peer->channel, CHANNEL_BYTES, kExporterLabel,
                                    strlen(kExporterLabel), NULL, 0, 0) == 1;
}
