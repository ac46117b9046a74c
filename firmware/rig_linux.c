#include "rig_linux.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// A key is a number within bounds, a text, or the name of a GPIO line, which no other key has.
struct linux_key {
  const char* name;
  size_t offset;
  enum { NUMBER, TEXT, LINE } kind;
  bool required;
  double lowest, highest;
};

#define KEY(field, kind, required, lowest, highest) \
  { "linux." #field, offsetof(struct rig_linux, field), kind, required, lowest, highest }
#define OPTIONAL_LINE(field) KEY(field, LINE, false, 0, 0)
#define OPTIONAL_TEXT(field) KEY(field, TEXT, false, 0, 0)
static const struct linux_key kKeys[RIG_LINUX_KEYS] = {
    KEY(gpio_chip, TEXT, true, 0, 0),
    KEY(spi_device, TEXT, true, 0, 0),
    KEY(blank_line, LINE, true, 0, 0),
    KEY(latch_line, LINE, true, 0, 0),
    KEY(trigger_line, LINE, true, 0, 0),
    KEY(lamp_line, LINE, true, 0, 0),
    KEY(analyser_line, LINE, true, 0, 0),
    KEY(cpu, NUMBER, true, 0, 1023),
    KEY(priority, NUMBER, true, 1, 99),
    KEY(spin_us, NUMBER, true, 0, 10000),
    OPTIONAL_LINE(heartbeat_line),
    OPTIONAL_LINE(ready_line),
    OPTIONAL_LINE(buzzer_line),
    OPTIONAL_LINE(start_line),
    OPTIONAL_LINE(estop_line),
    OPTIONAL_LINE(at_parallel_line),
    OPTIONAL_LINE(at_crossed_line),
    OPTIONAL_LINE(blank_seen_line),
    OPTIONAL_LINE(trigger_seen_line),
    OPTIONAL_TEXT(temperature_file),
    OPTIONAL_TEXT(display_device),
    OPTIONAL_TEXT(display_connector),
    OPTIONAL_TEXT(camera_left),
    OPTIONAL_TEXT(camera_right),
    OPTIONAL_TEXT(camera_trigger),
    OPTIONAL_TEXT(camera_left_controls),
    OPTIONAL_TEXT(camera_right_controls),
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
  const char* mine = (const char*)board + kKeys[index].offset;
  for (size_t i = 0; i < RIG_LINUX_KEYS; i++) {
    const char* other = (const char*)board + kKeys[i].offset;
    if (i != index && kKeys[i].kind == LINE && strcmp(other, mine) == 0) return true;
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
  if (known->kind == NUMBER) {
    if (!take_number(known, value, field, error)) return false;
    const bool whole = board->cpu == (int)board->cpu && board->priority == (int)board->priority;
    return whole || refuse(error, key, "must be a whole number");
  }
  if (!take_text(known, value, field, error)) return false;
  if (known->kind == TEXT || !is_shared(board, index)) return true;
  return refuse(error, key, "is a line that another key has");
}

const char* rig_linux_missing(const struct rig_linux* board) {
  for (size_t i = 0; i < RIG_LINUX_KEYS; i++) {
    if (kKeys[i].required && !board->seen[i]) return kKeys[i].name;
  }
  return NULL;
}
