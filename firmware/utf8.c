#include "utf8.h"

#include <string.h>

size_t utf8_bytes(const unsigned char* at, const unsigned char* end) {
  static const unsigned kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  if (*at < 0x80) return 1;
  const size_t bytes = *at >= 0xF0 ? 4 : *at >= 0xE0 ? 3 : 2;
  if (*at < 0xC0 || *at > 0xF7 || bytes > (size_t)(end - at)) return 0;
  unsigned code = *at & (0xFFu >> (bytes + 1));
  for (size_t i = 1; i < bytes; i++) {
    if (at[i] >> 6 != 2) return 0;
    code = code << 6 | (at[i] & 0x3Fu);
  }
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  return code >= kLeast[bytes] && code <= 0x10FFFF && !surrogate ? bytes : 0;
}

bool utf8_is_valid(const char* text) {
  const unsigned char* at = (const unsigned char*)text;
  const unsigned char* end = at + strlen(text);
  while (at < end) {
    const size_t bytes = utf8_bytes(at, end);
    if (bytes == 0) return false;
    at += bytes;
  }
  return true;
}
