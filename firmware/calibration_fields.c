#include "calibration_fields.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool fields_wrong(char why[FIELDS_WHY_CHARS], const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(why, FIELDS_WHY_CHARS, format, arguments);
  va_end(arguments);
  return false;
}

double number_of(const struct json_value* value) {
  char text[NUMBER_CHARS];
  if (value->kind != JSON_NUMBER || value->length >= sizeof text) return NAN;
  memcpy(text, value->text, value->length);
  text[value->length] = '\0';
  const double number = strtod(text, NULL);
  return isfinite(number) ? number : NAN;
}

// Length of the name that `part` begins with, which may have dots of its own.
static size_t match(const char* part, const char* name) {
  const char* at = part;
  for (; *name != '\0'; at++, name++) {
    if (*at == *name) continue;
    const bool camel = *name == '_' && *at == toupper((unsigned char)name[1]);
    if (!camel) return 0;
    name++;
  }
  return (size_t)(at - part);
}

static bool is_field(const char* part, const char* name) {
  const size_t length = match(part, name);
  return length > 0 && (part[length] == '\0' || part[length] == '.' || part[length] == '[');
}

bool is_null(const struct json_value* value) {
  return value->kind == JSON_WORD && *value->text == 'n';
}

static bool take_number(double* to, const struct field* field, const struct json_value* value,
                        char why[FIELDS_WHY_CHARS]) {
  const double number = number_of(value);
  if (isnan(number)) return fields_wrong(why, "%s is no number", value->path);
  if (number < field->least || number > field->most) {
    return fields_wrong(why, "%s is %.10g: it must be %s", value->path, number, field->must_be);
  }
  *to = number;
  return true;
}

static bool begin_field(struct numbers* numbers, const struct field* field, size_t index,
                        const struct json_value* value, char why[FIELDS_WHY_CHARS]) {
  if (field->count > 0 && value->kind != JSON_ARRAY) {
    return fields_wrong(why, "%s is no list of %d numbers", value->path, field->count);
  }
  if (numbers->given[index]) return fields_wrong(why, "%s is given twice", value->path);
  return numbers->given[index] = true;
}

static size_t room_of(const struct field* field) { return field->count > 0 ? field->count : 1; }

bool numbers_take(struct numbers* numbers, const struct field_group* group, const char* name,
                  const struct json_value* value, char why[FIELDS_WHY_CHARS]) {
  size_t first = 0, i = 0;
  while (i < group->count && !is_field(name, group->fields[i].name)) {
    first += room_of(&group->fields[i++]);
  }
  if (i == group->count) return true;
  const struct field* field = &group->fields[i];
  const bool itself = name[match(name, field->name)] == '\0';
  if (itself && is_null(value)) return true;  // proto3 JSON: left out
  if (itself && !begin_field(numbers, field, i, value, why)) return false;
  if (itself && field->count > 0) return true;
  if (numbers->taken[i] == room_of(field)) {
    return fields_wrong(why, "%s is one number too many: they are %d", value->path, field->count);
  }
  return take_number(&numbers->value[first + numbers->taken[i]++], field, value, why);
}

bool numbers_whole(const struct numbers* numbers, const struct field_group* group,
                   char why[FIELDS_WHY_CHARS]) {
  for (size_t i = 0; i < group->count; i++) {
    const struct field* field = &group->fields[i];
    if (field->required && !numbers->given[i]) return fields_wrong(why, "has no %s", field->name);
    const bool left_out = numbers->taken[i] == 0 && !field->required;  // an empty list
    if (numbers->given[i] && !left_out && numbers->taken[i] < room_of(field)) {
      return fields_wrong(why, "has %d numbers of its %s, not %d", numbers->taken[i], field->name,
                          field->count);
    }
  }
  return true;
}

const double* numbers_find(const struct numbers* numbers, const struct field_group* group,
                           const char* name) {
  size_t first = 0;
  for (size_t i = 0; i < group->count; first += room_of(&group->fields[i++])) {
    if (strcmp(group->fields[i].name, name) == 0) {
      return numbers->taken[i] > 0 ? &numbers->value[first] : NULL;
    }
  }
  return NULL;
}
