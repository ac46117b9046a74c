#include "link_trust.h"

#include <stdio.h>
#include <string.h>

// Letters, digits and a few signs: a name is shown on terminals and stands in a file of lines.
static bool is_name_char(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         strchr("-_. ", c) != NULL;
}

static void copy_name(char to[TRUST_NAME_CHARS], const char* from) {
  size_t length = 0;
  for (; from[length] != '\0' && length + 1 < TRUST_NAME_CHARS; length++) {
    to[length] = is_name_char(from[length]) ? from[length] : '_';
  }
  to[length] = '\0';
}

static struct trusted_host* find(struct trust* trust, const uint8_t* fingerprint) {
  for (size_t i = 0; i < trust->count; i++) {
    struct trusted_host* host = &trust->hosts[i];
    if (memcmp(host->fingerprint, fingerprint, FINGERPRINT_BYTES) == 0) return host;
  }
  return NULL;
}

bool trust_knows(const struct trust* trust, const uint8_t fingerprint[FINGERPRINT_BYTES]) {
  return find((struct trust*)trust, fingerprint) != NULL;
}

static bool take_line(struct trust* trust, const char* line, size_t length) {
  if (length <= FINGERPRINT_HEX || line[FINGERPRINT_HEX] != ' ') return false;
  const size_t name_length = length - FINGERPRINT_HEX - 1;
  if (name_length == 0 || name_length >= TRUST_NAME_CHARS) return false;
  if (trust->count == TRUST_MAX_HOSTS) return false;
  struct trusted_host* host = &trust->hosts[trust->count];
  if (!fingerprint_from_hex(line, host->fingerprint) || trust_knows(trust, host->fingerprint)) {
    return false;
  }
  for (size_t i = 0; i < name_length; i++) {
    const char c = line[FINGERPRINT_HEX + 1 + i];
    if (c == '\0' || !is_name_char(c)) return false;
    host->name[i] = c;
  }
  host->name[name_length] = '\0';
  trust->count++;
  return true;
}

int trust_parse(struct trust* trust, const char* text, size_t size) {
  trust->count = 0;
  int number = 1;
  for (size_t at = 0; at < size; number++) {
    const char* end = memchr(text + at, '\n', size - at);
    if (end == NULL || !take_line(trust, text + at, (size_t)(end - text) - at)) return number;
    at = (size_t)(end - text) + 1;
  }
  return 0;
}

enum lam_status trust_open(struct trust* trust, const char* folder, char* error,
                           size_t error_size) {
  memset(trust, 0, sizeof *trust);
  if (!link_file_path(folder, "paired_hosts", trust->path)) {
    snprintf(error, error_size, "the state folder's path is too long");
    return LAM_BAD_INPUT;
  }
  char text[LINK_FILE_MAX_BYTES];
  size_t size = 0;
  const enum lam_status status =
      link_file_read(trust->path, text, sizeof text, &size, error, error_size);
  if (status == LAM_WRONG_STATE) return LAM_OK;  // no such file: nobody yet
  if (status != LAM_OK) return status;
  const int line = trust_parse(trust, text, size);
  if (line == 0) return LAM_OK;
  snprintf(error, error_size,
           "%s:%d: not \"FINGERPRINT NAME\", or one too many; remove the line, or the file to pair "
           "anew",
           trust->path, line);
  trust->count = 0;
  return LAM_BAD_INPUT;
}

static enum lam_status write_hosts(const struct trust* trust, char* error, size_t error_size) {
  char text[TRUST_MAX_HOSTS * (FINGERPRINT_HEX + 1 + TRUST_NAME_CHARS) + 1];
  size_t size = 0;
  text[0] = '\0';
  for (size_t i = 0; i < trust->count; i++) {
    char hex[FINGERPRINT_HEX + 1];
    fingerprint_to_hex(trust->hosts[i].fingerprint, hex);
    size += (size_t)snprintf(text + size, sizeof text - size, "%s %s\n", hex, trust->hosts[i].name);
  }
  return link_file_write(trust->path, text, size, error, error_size);
}

enum lam_status trust_add(struct trust* trust, const uint8_t fingerprint[FINGERPRINT_BYTES],
                          const char* name, char* error, size_t error_size) {
  struct trust changed = *trust;
  struct trusted_host* host = find(&changed, fingerprint);
  if (host == NULL && changed.count == TRUST_MAX_HOSTS) {
    snprintf(error, error_size, "%s: holds %d hosts already; remove a line", trust->path,
             TRUST_MAX_HOSTS);
    return LAM_STORE_FULL;
  }
  if (host == NULL) host = &changed.hosts[changed.count++];
  memcpy(host->fingerprint, fingerprint, FINGERPRINT_BYTES);
  copy_name(host->name, name[0] != '\0' ? name : "host");
  const enum lam_status status = write_hosts(&changed, error, error_size);
  if (status == LAM_OK) *trust = changed;
  return status;
}

enum lam_status trust_remove(struct trust* trust, const uint8_t fingerprint[FINGERPRINT_BYTES],
                             char* error, size_t error_size) {
  struct trust changed = *trust;
  struct trusted_host* host = find(&changed, fingerprint);
  if (host == NULL) return LAM_OK;
  *host = changed.hosts[--changed.count];
  const enum lam_status status = write_hosts(&changed, error, error_size);
  if (status == LAM_OK) *trust = changed;
  return status;
}
