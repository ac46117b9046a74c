// The hosts that the rig lets in: a file of one line each, "FINGERPRINT NAME", in the state folder.
#ifndef LAMELLA_FIRMWARE_LINK_TRUST_H
#define LAMELLA_FIRMWARE_LINK_TRUST_H

#include "link_file.h"
#include "link_identity.h"

enum { TRUST_MAX_HOSTS = 16, TRUST_NAME_CHARS = 65 };

struct trusted_host {
  uint8_t fingerprint[FINGERPRINT_BYTES];
  char name[TRUST_NAME_CHARS];  // for people to read; nothing hangs on it
};

struct trust {
  char path[LINK_FILE_PATH_CHARS];
  struct trusted_host hosts[TRUST_MAX_HOSTS];
  size_t count;
};

// Reads `folder`/paired_hosts; none: nobody is trusted. A line that cannot be understood is
// LAM_BAD_INPUT: who guesses at such a file lets the wrong one in.
enum lam_status trust_open(struct trust* trust, const char* folder, char* error, size_t error_size);

// The file's text. 0, or the first line that is wrong.
int trust_parse(struct trust* trust, const char* text, size_t size);

bool trust_knows(const struct trust* trust, const uint8_t fingerprint[FINGERPRINT_BYTES]);

// Both are on the disk when they return LAM_OK, and change nothing otherwise. LAM_STORE_FULL: there
// are TRUST_MAX_HOSTS.
enum lam_status trust_add(struct trust* trust, const uint8_t fingerprint[FINGERPRINT_BYTES],
                          const char* name, char* error, size_t error_size);
enum lam_status trust_remove(struct trust* trust, const uint8_t fingerprint[FINGERPRINT_BYTES],
                             char* error, size_t error_size);

#endif
