#include "link_identity.h"

#include <openssl/bio.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/sha.h>
#include <openssl/x509.h>
#include <stdio.h>
#include <string.h>

#include "link_file.h"

static EVP_PKEY* parse_key(const char* text, size_t size) {
  BIO* bio = BIO_new_mem_buf(text, (int)size);
  // The empty passphrase keeps OpenSSL from asking for one on a terminal.
  EVP_PKEY* key = bio != NULL ? PEM_read_bio_PrivateKey(bio, NULL, NULL, "") : NULL;
  BIO_free(bio);
  return key;
}

static enum lam_status write_key(EVP_PKEY* key, const char* path, char* error, size_t error_size) {
  BIO* bio = BIO_new(BIO_s_secmem());
  char* text = NULL;
  enum lam_status status = LAM_HARDWARE;
  if (bio != NULL && PEM_write_bio_PrivateKey(bio, key, NULL, NULL, 0, NULL, NULL) == 1) {
    const long size = BIO_get_mem_data(bio, &text);
    status = link_file_write(path, text, (size_t)size, error, error_size);
  } else {
    snprintf(error, error_size, "%s: OpenSSL cannot encode the key", path);
  }
  BIO_free(bio);
  return status;
}

static enum lam_status make_key(struct identity* identity, const char* path, char* error,
                                size_t error_size) {
  identity->key = EVP_PKEY_Q_keygen(NULL, NULL, "ED25519");
  if (identity->key != NULL) return write_key(identity->key, path, error, error_size);
  snprintf(error, error_size, "%s: OpenSSL cannot make a key", path);
  return LAM_HARDWARE;
}

static enum lam_status read_or_make_key(struct identity* identity, const char* path, char* error,
                                        size_t error_size) {
  char text[LINK_FILE_MAX_BYTES];
  size_t size = 0;
  const enum lam_status status = link_file_read(path, text, sizeof text, &size, error, error_size);
  if (status == LAM_WRONG_STATE) return make_key(identity, path, error, error_size);
  if (status != LAM_OK) return status;
  identity->key = parse_key(text, size);
  OPENSSL_cleanse(text, sizeof text);
  if (identity->key != NULL) return LAM_OK;
  snprintf(error, error_size,
           "%s: no private key; remove it and pair again: the rig makes a new one", path);
  return LAM_BAD_INPUT;
}

// A rig's clock may stand at 1970: the certificate holds from then on and has no end (RFC 5280).
static bool make_certificate(struct identity* identity) {
  X509* certificate = identity->certificate = X509_new();
  if (certificate == NULL) return false;
  X509_NAME* name = X509_get_subject_name(certificate);
  const EVP_MD* digest = EVP_PKEY_get_id(identity->key) == EVP_PKEY_ED25519 ? NULL : EVP_sha256();
  return X509_set_version(certificate, X509_VERSION_3) == 1 &&
         ASN1_INTEGER_set(X509_get_serialNumber(certificate), 1) == 1 &&
         ASN1_TIME_set_string(X509_getm_notBefore(certificate), "19700101000000Z") == 1 &&
         ASN1_TIME_set_string(X509_getm_notAfter(certificate), "99991231235959Z") == 1 &&
         X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, (const unsigned char*)"lamella", -1,
                                    -1, 0) == 1 &&
         X509_set_issuer_name(certificate, name) == 1 &&
         X509_set_pubkey(certificate, identity->key) == 1 &&
         X509_sign(certificate, identity->key, digest) > 0;
}

enum lam_status identity_open(struct identity* identity, const char* folder, char* error,
                              size_t error_size) {
  memset(identity, 0, sizeof *identity);
  char path[LINK_FILE_PATH_CHARS];
  if (!link_file_path(folder, "key.pem", path)) {
    snprintf(error, error_size, "the state folder's path is too long");
    return LAM_BAD_INPUT;
  }
  const enum lam_status status = read_or_make_key(identity, path, error, error_size);
  if (status != LAM_OK) {
    identity_close(identity);
    return status;
  }
  if (make_certificate(identity) &&
      identity_fingerprint(identity->certificate, identity->fingerprint)) {
    return LAM_OK;
  }
  snprintf(error, error_size, "%s: neither an Ed25519 nor a P-256 key", path);
  identity_close(identity);
  return LAM_BAD_INPUT;
}

void identity_close(struct identity* identity) {
  X509_free(identity->certificate);
  EVP_PKEY_free(identity->key);
  memset(identity, 0, sizeof *identity);
}

static bool is_p256(const EVP_PKEY* key) {
  char group[32];
  return EVP_PKEY_is_a(key, "EC") && EVP_PKEY_get_group_name(key, group, sizeof group, NULL) == 1 &&
         strcmp(group, "prime256v1") == 0;
}

bool identity_fingerprint(const X509* certificate, uint8_t fingerprint[FINGERPRINT_BYTES]) {
  const EVP_PKEY* key = X509_get0_pubkey(certificate);
  if (key == NULL || !(EVP_PKEY_is_a(key, "ED25519") || is_p256(key))) return false;
  unsigned char* der = NULL;
  const int size = i2d_X509_PUBKEY(X509_get_X509_PUBKEY(certificate), &der);
  if (size <= 0) return false;
  SHA256(der, (size_t)size, fingerprint);
  OPENSSL_free(der);
  return true;
}

bool identity_fingerprint_der(const uint8_t* der, size_t size,
                              uint8_t fingerprint[FINGERPRINT_BYTES]) {
  const unsigned char* at = der;
  X509* certificate = d2i_X509(NULL, &at, (long)size);
  const bool good =
      certificate != NULL && at == der + size && identity_fingerprint(certificate, fingerprint);
  X509_free(certificate);
  return good;
}

void fingerprint_to_hex(const uint8_t fingerprint[FINGERPRINT_BYTES],
                        char hex[FINGERPRINT_HEX + 1]) {
  for (int i = 0; i < FINGERPRINT_BYTES; i++) snprintf(hex + 2 * i, 3, "%02x", fingerprint[i]);
}

static int digit_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

bool fingerprint_from_hex(const char* hex, uint8_t fingerprint[FINGERPRINT_BYTES]) {
  for (int i = 0; i < FINGERPRINT_BYTES; i++) {
    const int high = digit_of(hex[2 * i]);
    const int low = high < 0 ? -1 : digit_of(hex[2 * i + 1]);
    if (low < 0) return false;
    fingerprint[i] = (uint8_t)(high << 4 | low);
  }
  return true;
}
