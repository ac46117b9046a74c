#include "json_scan.h"

#include <stdio.h>
#include <string.h>

#include "utf8.h"

enum { kMaxDepth = 64, kMaxPathChars = 64 };

struct scan {
  const unsigned char *at, *end;
  int line, depth;
  char path[kMaxPathChars];
  size_t path_length;  // beyond the room: it has no name
  void (*take)(void* context, const struct json_value* value);
  void* context;
  struct json_error* error;
};

static bool scan_value(struct scan* scan);

static bool fail(struct scan* scan, const char* what) {
  *scan->error = (struct json_error){scan->line, what};
  return false;
}

static int next(const struct scan* scan) { return scan->at < scan->end ? *scan->at : -1; }

static void skip_blank(struct scan* scan) {
  for (int c; (c = next(scan)) == ' ' || c == '\t' || c == '\r' || c == '\n'; scan->at++) {
    scan->line += c == '\n';
  }
}

// Passes over `c` and the blanks before it.
static bool skip(struct scan* scan, int c) {
  skip_blank(scan);
  if (next(scan) != c) return false;
  scan->at++;
  return true;
}

static void tell(struct scan* scan, enum json_kind kind, const unsigned char* text, size_t length) {
  const bool named = scan->path_length < sizeof scan->path;
  if (named) scan->path[scan->path_length] = '\0';
  const struct json_value value = {.path = named ? scan->path : "?",
                                   .kind = kind,
                                   .text = (const char*)text,
                                   .length = length,
                                   .line = scan->line};
  scan->take(scan->context, &value);
}

static int hex_digit(int c) {
  if (c >= '0' && c <= '9') return c - '0';
  if ((c | 0x20) >= 'a' && (c | 0x20) <= 'f') return (c | 0x20) - 'a' + 10;
  return -1;
}

// The code unit of UTF-16 that 'u' and four hexadecimal digits are; -1 where they are not there.
static int read_unit(struct scan* scan) {
  if (next(scan) != 'u') return -1;
  scan->at++;
  int unit = 0;
  for (int i = 0; i < 4; i++, scan->at++) {
    const int digit = hex_digit(next(scan));
    if (digit < 0) return -1;
    unit = unit << 4 | digit;
  }
  return unit;
}

// What comes after a backslash.
static bool skip_escape(struct scan* scan) {
  static const char kPlain[] = "\"\\/bfnrt";
  const int c = next(scan);
  if (c > 0 && strchr(kPlain, c) != NULL) {
    scan->at++;
    return true;
  }
  if (c != 'u') return fail(scan, "a backslash before something that needs none");
  const int unit = read_unit(scan);
  if (unit < 0) return fail(scan, "\\u needs four hexadecimal digits");
  if (unit >> 11 != 0xD800 >> 11) return true;  // no half of a pair
  const bool first = unit < 0xDC00 && next(scan) == '\\';
  if (first) scan->at++;
  if (first && read_unit(scan) >> 10 == 0xDC00 >> 10) return true;
  return fail(scan, "half a character");
}

// After its first quote; `text` and `length` are what is between the two.
static bool scan_string(struct scan* scan, const unsigned char** text, size_t* length) {
  *text = scan->at;
  while (next(scan) != '"') {
    if (next(scan) < ' ') return fail(scan, "a string does not end on its line");
    if (next(scan) == '\\') {
      scan->at++;
      if (!skip_escape(scan)) return false;
      continue;
    }
    const size_t bytes = utf8_bytes(scan->at, scan->end);
    if (bytes == 0) return fail(scan, "not UTF-8");
    scan->at += bytes;
  }
  *length = (size_t)(scan->at - *text);
  scan->at++;
  return true;
}

static bool skip_digits(struct scan* scan) {
  const unsigned char* from = scan->at;
  while (next(scan) >= '0' && next(scan) <= '9') scan->at++;
  return scan->at > from;
}

static bool scan_number(struct scan* scan) {
  const unsigned char* text = scan->at;
  if (next(scan) == '-') scan->at++;
  const bool zero = next(scan) == '0';
  const unsigned char* digits = scan->at;
  bool good = skip_digits(scan) && !(zero && scan->at - digits > 1);
  if (good && next(scan) == '.') {
    scan->at++;
    good = skip_digits(scan);
  }
  if (good && (next(scan) == 'e' || next(scan) == 'E')) {
    scan->at++;
    if (next(scan) == '+' || next(scan) == '-') scan->at++;
    good = skip_digits(scan);
  }
  if (!good) return fail(scan, text == scan->at ? "no value begins here" : "not a number");
  tell(scan, JSON_NUMBER, text, (size_t)(scan->at - text));
  return true;
}

static bool scan_word(struct scan* scan, const char* word) {
  const size_t length = strlen(word);
  if ((size_t)(scan->end - scan->at) < length || memcmp(scan->at, word, length) != 0) {
    return fail(scan, "no value begins here");
  }
  scan->at += length;
  tell(scan, JSON_WORD, scan->at - length, length);
  return true;
}

// A name that has something else than letters, digits and '_' could be taken for a path.
static bool is_plain(const unsigned char* name, size_t length) {
  for (size_t i = 0; i < length; i++) {
    const unsigned char c = name[i];
    const bool letter = (c | 0x20) >= 'a' && (c | 0x20) <= 'z';
    if (!letter && !(c >= '0' && c <= '9') && c != '_') return false;
  }
  return length > 0;
}

// A letter that is written as \\u0061: a host reads it as one, and finds a name that nobody else
// does.
static bool hides_a_letter(const unsigned char* name, size_t length) {
  for (size_t i = 0; i + 6 <= length; i++) {
    if (name[i] == '\\' && memcmp(name + i + 1, "u00", 3) == 0 && name[i + 4] < '8') return true;
  }
  return false;
}

static void enter_member(struct scan* scan, const unsigned char* name, size_t length) {
  const size_t room = sizeof scan->path, dot = scan->path_length > 0;
  if (!is_plain(name, length) || scan->path_length + dot + length >= room) {
    scan->path_length = room;
    return;
  }
  if (dot) scan->path[scan->path_length++] = '.';
  memcpy(scan->path + scan->path_length, name, length);
  scan->path_length += length;
}

static void enter_element(struct scan* scan, size_t index) {
  const size_t room = sizeof scan->path;
  if (scan->path_length >= room) return;
  const int length =
      snprintf(scan->path + scan->path_length, room - scan->path_length, "[%zu]", index);
  scan->path_length += (size_t)length;
}

static bool scan_member(struct scan* scan) {
  const unsigned char* name = NULL;
  size_t length = 0;
  const size_t outside = scan->path_length;
  if (!skip(scan, '"')) return fail(scan, "a name in quotes is due");
  if (!scan_string(scan, &name, &length)) return false;
  if (!skip(scan, ':')) return fail(scan, "a name without ':'");
  if (length == 0) return fail(scan, "a name that is empty");
  if (hides_a_letter(name, length)) return fail(scan, "a name with a letter written as \\u00..");
  enter_member(scan, name, length);
  const bool good = scan_value(scan);
  scan->path_length = outside;
  return good;
}

static bool scan_element(struct scan* scan, size_t index) {
  const size_t outside = scan->path_length;
  enter_element(scan, index);
  const bool good = scan_value(scan);
  scan->path_length = outside;
  return good;
}

// After its first bracket.
static bool scan_nested(struct scan* scan, bool is_object) {
  const int close = is_object ? '}' : ']';
  if (++scan->depth > kMaxDepth) return fail(scan, "nested deeper than anything of a session");
  tell(scan, is_object ? JSON_OBJECT : JSON_ARRAY, scan->at - 1, 1);
  for (size_t i = 0; !skip(scan, close); i++) {
    if (i > 0 && !skip(scan, ',')) return fail(scan, "',' or a closing bracket is due");
    if (!(is_object ? scan_member(scan) : scan_element(scan, i))) return false;
  }
  scan->depth--;
  return true;
}

static bool scan_value(struct scan* scan) {
  skip_blank(scan);
  const int c = next(scan);
  if (c < 0) return fail(scan, "it ends too early");
  if (c == '{' || c == '[') {
    scan->at++;
    return scan_nested(scan, c == '{');
  }
  if (c == 't') return scan_word(scan, "true");
  if (c == 'f') return scan_word(scan, "false");
  if (c == 'n') return scan_word(scan, "null");
  if (c != '"') return scan_number(scan);
  const unsigned char* text = NULL;
  size_t length = 0;
  scan->at++;
  if (!scan_string(scan, &text, &length)) return false;
  tell(scan, JSON_STRING, text, length);
  return true;
}

bool json_scan(const char* text, size_t length,
               void (*take)(void* context, const struct json_value* value), void* context,
               struct json_error* error) {
  static const char kByteOrderMark[] = "\xEF\xBB\xBF";
  if (length >= 3 && memcmp(text, kByteOrderMark, 3) == 0) {
    text += 3;
    length -= 3;
  }
  struct scan scan = {.at = (const unsigned char*)text,
                      .end = (const unsigned char*)text + length,
                      .line = 1,
                      .take = take,
                      .context = context,
                      .error = error};
  if (!scan_value(&scan)) return false;
  skip_blank(&scan);
  return scan.at == scan.end || fail(&scan, "something comes after its end");
}
