#include "rig_text.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { kMaxLineBytes = 160, kToldBytes = 90 };

void rig_complain(struct rig_errors* errors, int line, const char* format, ...) {
  if (errors->count < RIG_MAX_ERRORS) {
    struct rig_error* error = &errors->list[errors->count];
    error->in_leds = errors->in_leds;
    error->line = line;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
  }
  errors->count++;
}

static char* trim(char* text) {
  static const char kBlank[] = " \t\r";
  text += strspn(text, kBlank);
  size_t length = strlen(text);
  while (length > 0 && strchr(kBlank, text[length - 1]) != NULL) text[--length] = '\0';
  return text;
}

// False where the line holds no pair, which is an error unless it holds nothing at all.
static bool split(char* line, struct rig_errors* errors, struct rig_pair* pair) {
  line[strcspn(line, "#")] = '\0';
  char* key = trim(line);
  if (*key == '\0') return false;
  char* equals = strchr(key, '=');
  if (equals == NULL) {
    rig_complain(errors, pair->line, "'%.*s%s' is not 'key = value'", kToldBytes, key,
                 strlen(key) > kToldBytes ? "..." : "");
    return false;
  }
  *equals = '\0';
  pair->key = trim(key);
  pair->value = trim(equals + 1);
  return true;
}

static const char* skip_digits(const char* text) { return text + strspn(text, "0123456789"); }

static const char* skip_sign(const char* text) { return text + (*text == '-' || *text == '+'); }

const char* rig_text_number(const char* text, double* number) {
  const char* whole = skip_sign(text);
  const char* point = skip_digits(whole);
  const char* end = *point == '.' ? skip_digits(point + 1) : point;
  if (end - whole == (*point == '.')) return NULL;  // no digit
  if (*end == 'e' || *end == 'E') {
    const char* power = skip_sign(end + 1);
    if (skip_digits(power) > power) end = skip_digits(power);
  }
  *number = strtod(text, NULL);
  return isfinite(*number) ? end : NULL;
}

// Letters beyond ASCII may stand in comments.
static bool is_text(const char* text, size_t length, struct rig_errors* errors) {
  int line = 1;
  if (length > RIG_MAX_TEXT_BYTES) {
    rig_complain(errors, 0, "longer than %d bytes", RIG_MAX_TEXT_BYTES);
    return false;
  }
  for (size_t i = 0; i < length; i++) {
    const unsigned char byte = (unsigned char)text[i];
    line += byte == '\n';
    const bool blank = byte == '\t' || byte == '\r' || byte == '\n';
    if (blank || (byte >= ' ' && byte != 0x7F)) continue;
    rig_complain(errors, line, "not a text file: it has a byte 0x%02X", byte);
    return false;
  }
  return true;
}

// Some editors put a byte order mark before UTF-8.
static size_t mark_bytes(const char* text, size_t length) {
  static const char kMark[] = "\xEF\xBB\xBF";
  const size_t bytes = sizeof kMark - 1;
  return length >= bytes && memcmp(text, kMark, bytes) == 0 ? bytes : 0;
}

bool rig_text_each_pair(const char* text, size_t length, struct rig_errors* errors,
                        void (*take)(void* context, const struct rig_pair* pair), void* context) {
  struct rig_pair pair = {0};
  if (!is_text(text, length, errors)) return false;
  for (size_t at = mark_bytes(text, length), bytes; at < length; at += bytes + 1) {
    const char* newline = memchr(text + at, '\n', length - at);
    bytes = newline != NULL ? (size_t)(newline - (text + at)) : length - at;
    pair.line++;
    char line[kMaxLineBytes];
    if (bytes >= sizeof line) {
      rig_complain(errors, pair.line, "line too long: at most %d bytes", kMaxLineBytes - 1);
      continue;
    }
    memcpy(line, text + at, bytes);
    line[bytes] = '\0';
    if (split(line, errors, &pair)) take(context, &pair);
  }
  return true;
}

struct search {
  const char* key;
  size_t key_chars;
  int line;
};

static void compare_key(void* context, const struct rig_pair* pair) {
  struct search* search = context;
  const bool same = strlen(pair->key) == search->key_chars &&
                    memcmp(pair->key, search->key, search->key_chars) == 0;
  if (same && search->line == 0) search->line = pair->line;
}

int rig_text_line_blamed(const char* text, size_t length, const char* complaint) {
  static struct rig_errors known;  // told when the text was first read
  struct search search = {0};
  const char* quote = strchr(complaint, '\'');
  for (; quote != NULL && search.line == 0; quote = strchr(quote + 1, '\'')) {
    search.key = quote + 1;
    search.key_chars = strspn(search.key, "abcdefghijklmnopqrstuvwxyz0123456789_.");
    rig_text_each_pair(text, length, &known, compare_key, &search);
  }
  return search.line;
}
