#include "complain.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "utf8.h"

enum { kMostBytes = 4096, kEscapeBytes = 4 };

// U+0080 to U+009F: control characters of one byte once.
static bool is_obeyed(const unsigned char* at, size_t bytes) {
  if (bytes == 2) return at[0] == 0xC2 && at[1] < 0xA0;
  return bytes == 0 || at[0] < ' ' || at[0] == 0x7F;
}

// Puts the character that begins at `*at` and goes on behind it.
static size_t put_shown(char* to, const unsigned char** at, const unsigned char* end) {
  const size_t bytes = utf8_bytes(*at, end);
  const unsigned char* first = *at;
  *at += bytes == 0 ? 1 : bytes;
  if (!is_obeyed(first, bytes)) {
    memcpy(to, first, bytes);
    return bytes;
  }
  if (*first == '\n') return (size_t)snprintf(to, kEscapeBytes + 1, "\\n");
  return (size_t)snprintf(to, kEscapeBytes + 1, "\\x%02x", (unsigned)(*at)[-1]);
}

void complain(const char* format, ...) {
  char text[kMostBytes], line[kMostBytes];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  size_t used = 0;
  const unsigned char* at = (const unsigned char*)text;
  for (const unsigned char* end = at + strlen(text); at < end;) {
    if (used + kEscapeBytes + 2 > sizeof line) {
      fwrite(line, 1, used, stderr);
      used = 0;
    }
    used += put_shown(line + used, &at, end);
  }
  line[used++] = '\n';
  fwrite(line, 1, used, stderr);
}
