// The numbers of one object of a calibration: what each is called, how many it is, and from where
// to where it is a number that a host can use (host/io/rig_message.cpp).
#ifndef LAMELLA_FIRMWARE_CALIBRATION_FIELDS_H
#define LAMELLA_FIRMWARE_CALIBRATION_FIELDS_H

#include <stdbool.h>
#include <stddef.h>

#include "json_scan.h"

enum { FIELDS_MOST = 13, FIELDS_MOST_NUMBERS = 32, FIELDS_WHY_CHARS = 160, NUMBER_CHARS = 512 };

struct field {
  const char* name;     // of session.proto; lowerCamelCase is taken for it too, as proto3 JSON does
  unsigned char count;  // of the numbers in its list; 0: a number alone
  bool required;
  double least, most;
  const char* must_be;  // "a positive number"
};

struct field_group {
  const struct field* fields;
  size_t count;  // at most FIELDS_MOST, of at most FIELDS_MOST_NUMBERS numbers
};

struct numbers {
  bool given[FIELDS_MOST];
  unsigned char taken[FIELDS_MOST];
  double value[FIELDS_MOST_NUMBERS];
};

// NaN where it is no number, or none that a double holds.
double number_of(const struct json_value* value);

// Takes a value whose path, within the object, is `name`: "rotation[3]". What no field is called is
// passed over. False, with what is wrong, where a host would refuse it.
bool numbers_take(struct numbers* numbers, const struct field_group* group, const char* name,
                  const struct json_value* value, char why[FIELDS_WHY_CHARS]);

// False, with what is missing, where a field that is required was not given or a list is too short.
bool numbers_whole(const struct numbers* numbers, const struct field_group* group,
                   char why[FIELDS_WHY_CHARS]);

// The first number of a field that the group has; NULL where it was not given.
const double* numbers_find(const struct numbers* numbers, const struct field_group* group,
                           const char* name);

// proto3 JSON: stands for "left out".
bool is_null(const struct json_value* value);

// Says in `why` what is wrong; false.
bool fields_wrong(char why[FIELDS_WHY_CHARS], const char* format, ...)
    __attribute__((format(printf, 2, 3)));

#endif
