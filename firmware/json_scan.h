// A JSON text (RFC 8259), read once from front to back: every value with its path. Nothing is kept
// of it, so that a text of any size needs no memory.
#ifndef LAMELLA_FIRMWARE_JSON_SCAN_H
#define LAMELLA_FIRMWARE_JSON_SCAN_H

#include <stdbool.h>
#include <stddef.h>

enum json_kind { JSON_OBJECT, JSON_ARRAY, JSON_STRING, JSON_NUMBER, JSON_WORD };

struct json_value {
  // "rig.cameras[0].width"; "" of the whole text. "?" where it is longer than anybody asks for, or
  // where a name on the way has other characters than letters, digits and '_'.
  const char* path;
  enum json_kind kind;  // an object or an array is told before what is in it
  const char* text;     // as written; of a string what is between its quotes. Not of what is nested
  size_t length;
  int line;  // from 1
};

struct json_error {
  int line;
  const char* what;
};

// Calls `take` for every value, in order. False, with the first error, where it is no JSON, nested
// deeper than 64, or has a name that is empty or hides a letter behind \u, which no host reads:
// what was told before is worth nothing then. A byte-order mark before it is passed over.
bool json_scan(const char* text, size_t length,
               void (*take)(void* context, const struct json_value* value), void* context,
               struct json_error* error);

#endif
