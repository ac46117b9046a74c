#include "link_announce.h"

#include <stdio.h>
#include <string.h>

static const char kService[] =
    "<?xml version=\"1.0\" standalone='no'?>\n"
    "<!DOCTYPE service-group SYSTEM \"avahi-service.dtd\">\n"
    "<service-group>\n"
    "  <name replace-wildcards=\"%s\">%s</name>\n"
    "  <service protocol=\"ipv4\">\n"
    "    <type>_lamella._tcp</type>\n"
    "    <port>%u</port>\n"
    "    <txt-record>version=1</txt-record>\n"
    "    <txt-record>fingerprint=%.16s</txt-record>\n"
    "  </service>\n"
    "</service-group>\n";

// A name as it may stand in XML and be a service's: letters, digits and a few signs.
static bool copy_name(const char* from, char to[TRUST_NAME_CHARS]) {
  const size_t length = strlen(from);
  if (length == 0 || length > 63) return false;
  for (size_t i = 0; i <= length; i++) to[i] = from[i];
  return strpbrk(to, "<>&\"'") == NULL;
}

static enum lam_status fail(char* error, size_t error_size, const char* why) {
  snprintf(error, error_size, "--announce: %s", why);
  return LAM_BAD_INPUT;
}

enum lam_status announce_write(const char* path, const struct link_place* place, char* error,
                               size_t error_size) {
  if (place->state == NULL || place->address == NULL) {
    return fail(error, error_size, "needs --state FOLDER and --listen ADDRESS:PORT");
  }
  const char* colon = strrchr(place->address, ':');
  unsigned port = 0;
  if (colon == NULL || sscanf(colon + 1, "%5u", &port) != 1 || port == 0 || port > 65535) {
    return fail(error, error_size, "--listen has no fixed port");
  }
  char name[TRUST_NAME_CHARS] = "%h", hex[FINGERPRINT_HEX + 1], text[1024];
  if (place->name != NULL && !copy_name(place->name, name)) {
    return fail(error, error_size, "--name is empty, over 63 bytes, or has one of <>&\"'");
  }
  struct identity identity;
  const enum lam_status status = identity_open(&identity, place->state, error, error_size);
  if (status != LAM_OK) return status;
  fingerprint_to_hex(identity.fingerprint, hex);
  identity_close(&identity);
  const int size =
      snprintf(text, sizeof text, kService, place->name == NULL ? "yes" : "no", name, port, hex);
  return link_file_write(path, text, (size_t)size, error, error_size);
}
