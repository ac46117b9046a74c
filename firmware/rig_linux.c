#include "rig_linux.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// A key is a text (a device's path or a line's name), or a number within bounds.
struct linux_key {
  const char* name;
  size_t offset;
  bool is_text;
  double lowest, highest;
};

#define TEXT(field) \
  { "linux." #field, offsetof(struct rig_linux, field), true, 0, 0 }
#define NUMBER(field, lowest, highest) \
  { "linux." #field, offsetof(struct rig_linux, field), false, lowest, highest }
static const struct linux_key kKeys[RIG_LINUX_KEYS] = {
    TEXT(gpio_chip),      TEXT(spi_device),        TEXT(blank_line),
    TEXT(latch_line),     TEXT(trigger_line),      TEXT(lamp_line),
    NUMBER(cpu, 0, 1023), NUMBER(priority, 1, 99), NUMBER(spin_us, 0, 10000),
};

static bool refuse(char error[160], const char* key, const char* why) {
  snprintf(error, 160, "'%.40s' %s", key, why);
  return false;
}

static bool take_text(const struct linux_key* key, const char* value, char* field, char* error) {
  if (*value == '\0') return refuse(error, key->name, "is empty");
  if (strlen(value) >= RIG_DEVICE_CHARS) return refuse(error, key->name, "is too long");
  snprintf(field, RIG_DEVICE_CHARS, "%s", value);
  return true;
}

static bool take_number(const struct linux_key* key, const char* value, void* field, char* error) {
  char* end = NULL;
  const double number = strtod(value, &end);
  if (end == value || *end != '\0') return refuse(error, key->name, "needs one number");
  if (!(number >= key->lowest && number <= key->highest)) {
    snprintf(error, 160, "'%s' is %.10g; it must be between %.10g and %.10g", key->name, number,
             key->lowest, key->highest);
    return false;
  }
  memcpy(field, &number, sizeof number);
  return true;
}

// Two outputs on one line would move together.
static bool is_shared(const struct rig_linux* board, size_t index) {
  const char* const lines[] = {board->blank_line, board->latch_line, board->trigger_line,
                               board->lamp_line};
  const char* mine = (const char*)board + kKeys[index].offset;
  for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
    if (lines[i] != mine && strcmp(lines[i], mine) == 0) return true;
  }
  return false;
}

bool rig_linux_take(struct rig_linux* board, const char* key, const char* value, char error[160]) {
  board->given = true;
  size_t index = 0;
  while (index < RIG_LINUX_KEYS && strcmp(key, kKeys[index].name) != 0) index++;
  if (index == RIG_LINUX_KEYS) return refuse(error, key, "is an unknown key");
  if (board->seen[index]) return refuse(error, key, "is given twice");
  board->seen[index] = true;
  const struct linux_key* known = &kKeys[index];
  char* field = (char*)board + known->offset;
  if (!known->is_text) {
    if (!take_number(known, value, field, error)) return false;
    const bool whole = board->cpu == (int)board->cpu && board->priority == (int)board->priority;
    return whole || refuse(error, key, "must be a whole number");
  }
  if (!take_text(known, value, field, error)) return false;
  return !is_shared(board, index) || refuse(error, key, "is a line that another output has");
}

const char* rig_linux_missing(const struct rig_linux* board) {
  for (size_t i = 0; i < RIG_LINUX_KEYS; i++) {
    if (!board->seen[i]) return kKeys[i].name;
  }
  return NULL;
}
