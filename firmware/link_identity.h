// Who speaks on a TLS connection: a private key of one's own, and the fingerprint of a public one.
//
// A certificate here is nothing but a wrapper of a key: self-signed, made anew at every start,
// without an end. What is compared is the SHA-256 of its public key (SubjectPublicKeyInfo, DER).
#ifndef LAMELLA_FIRMWARE_LINK_IDENTITY_H
#define LAMELLA_FIRMWARE_LINK_IDENTITY_H

#include <openssl/types.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "status.h"

enum { FINGERPRINT_BYTES = 32, FINGERPRINT_HEX = 2 * FINGERPRINT_BYTES };

struct identity {
  EVP_PKEY* key;
  X509* certificate;
  uint8_t fingerprint[FINGERPRINT_BYTES];
};

// Reads `folder`/key.pem, or makes an Ed25519 key and writes it there, mode 0600, whole or not at
// all. A key that others may read is refused. `error` is one line.
enum lam_status identity_open(struct identity* identity, const char* folder, char* error,
                              size_t error_size);
void identity_close(struct identity* identity);

// False where the key is of no kind that this link uses (Ed25519, P-256).
bool identity_fingerprint(const X509* certificate, uint8_t fingerprint[FINGERPRINT_BYTES]);

// The same of bytes as they come: one DER certificate and nothing after it.
bool identity_fingerprint_der(const uint8_t* der, size_t size,
                              uint8_t fingerprint[FINGERPRINT_BYTES]);

void fingerprint_to_hex(const uint8_t fingerprint[FINGERPRINT_BYTES],
                        char hex[FINGERPRINT_HEX + 1]);
// Reads 64 lower-case digits.
bool fingerprint_from_hex(const char* hex, uint8_t fingerprint[FINGERPRINT_BYTES]);

#endif
