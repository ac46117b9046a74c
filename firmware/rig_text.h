// What a rig file and a list of LEDs have in common: lines of `key = value`, '#' starts a comment,
// and a list of everything that is wrong.
#ifndef LAMELLA_FIRMWARE_RIG_TEXT_H
#define LAMELLA_FIRMWARE_RIG_TEXT_H

#include <stdbool.h>
#include <stddef.h>

#include "status.h"

enum {
  RIG_TEXT_CHARS = 64,
  RIG_MAX_ERRORS = 128,
  RIG_MAX_TEXT_BYTES = 65536,
};

struct rig_error {
  bool in_leds;  // the line is of the list of LEDs
  int line;      // from 1; 0 where no line is to blame (a missing key)
  char text[160];
};

struct rig_errors {
  size_t count;  // all that were found; the first RIG_MAX_ERRORS are kept
  bool in_leds;  // which text is being read
  struct rig_error list[RIG_MAX_ERRORS];
};

void rig_complain(struct rig_errors* errors, int line, const char* format, ...)
    __attribute__((format(printf, 3, 4)));

// Where a pair stands, for whoever takes it.
struct rig_pair {
  int line;
  const char *key, *value;
};

// A decimal number that a text begins with, as "-0.5" or "2.5e6", and the end of it; NULL where
// there is none that is finite. strtod() would take "0x10", "inf" and "nan" too.
const char* rig_text_number(const char* text, double* number);

// Calls `take` for every pair of the text, and complains of every line that is none. False, with
// one complaint, where it is no text at all: then nothing in it is missing either.
bool rig_text_each_pair(const char* text, size_t length, struct rig_errors* errors,
                        void (*take)(void* context, const struct rig_pair* pair), void* context);

// A complaint quotes the keys that it is of, as 'camera.format' or 'camera.format = Y10P'. The line
// of the first of them that the text gives; 0 where it gives none.
int rig_text_line_blamed(const char* text, size_t length, const char* complaint);

#endif
