// The list of LEDs: `led.count = LEDS`, which tells a list that was cut off, then
// `led.N = chip output x y z`, N counting from 0 without a gap.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "led_chain.h"
#include "rig.h"

struct led_reader {
  struct rig* rig;
  struct rig_errors* errors;
  size_t due;    // the number of the next LED
  size_t count;  // that are announced; 0: not yet
  int count_line, last_line;
  bool output_used[CHAIN_CHIPS][CHAIN_OUTPUTS];
};

// Reads on behind the number that stands there, so that one gap is one complaint.
static bool number_is_due(struct led_reader* reader, const struct rig_pair* pair) {
  char* end = NULL;
  const bool counts =
      strncmp(pair->key, "led.", 4) == 0 && pair->key[4] >= '0' && pair->key[4] <= '9';
  const unsigned long number = counts ? strtoul(pair->key + 4, &end, 10) : 0;
  const bool known = counts && *end == '\0' && number < RIG_MAX_LEDS;
  const bool due = known && number == reader->due;
  if (!due) {
    rig_complain(reader->errors, pair->line,
                 "'%.40s' stands where 'led.%zu' is due (at most %d LEDs)", pair->key, reader->due,
                 RIG_MAX_LEDS);
  }
  reader->due = (known ? number : reader->due) + 1;
  return due;
}

static bool take_output(struct led_reader* reader, const struct rig_pair* pair, int chip,
                        int output) {
  if (chip < 0 || chip >= CHAIN_CHIPS || output < 0 || output >= CHAIN_OUTPUTS) {
    rig_complain(reader->errors, pair->line,
                 "'%s' is at chip %d output %d; chips are 0 to %d, outputs 0 to %d", pair->key,
                 chip, output, CHAIN_CHIPS - 1, CHAIN_OUTPUTS - 1);
    return false;
  }
  if (reader->output_used[chip][output]) {
    rig_complain(reader->errors, pair->line, "'%s' is at chip %d output %d, which another LED has",
                 pair->key, chip, output);
    return false;
  }
  return reader->output_used[chip][output] = true;
}

static void take_count(struct led_reader* reader, const struct rig_pair* pair) {
  char* end = NULL;
  const unsigned long count = strtoul(pair->value, &end, 10);
  if (reader->count > 0) {
    rig_complain(reader->errors, pair->line, "'led.count' is given twice, on line %d before",
                 reader->count_line);
  } else if (pair->value[0] < '0' || pair->value[0] > '9' || *end != '\0' || count < 1 ||
             count > RIG_MAX_LEDS) {
    rig_complain(reader->errors, pair->line, "'led.count' is a whole number from 1 to %d",
                 RIG_MAX_LEDS);
  } else {
    reader->count = count;
    reader->count_line = pair->line;
  }
}

// Decimal numbers, with blanks between them and nothing else.
static bool read_numbers(const char* text, double numbers[], size_t count) {
  for (size_t i = 0; i < count; i++) {
    text = rig_text_number(text + strspn(text, " \t"), &numbers[i]);
    if (text == NULL || (*text != '\0' && *text != ' ' && *text != '\t')) return false;
  }
  return *text == '\0';
}

static bool is_int(double number) { return number == floor(number) && fabs(number) < 1e6; }

static void take_led(void* context, const struct rig_pair* pair) {
  struct led_reader* reader = context;
  reader->last_line = pair->line;
  if (strcmp(pair->key, "led.count") == 0) {
    take_count(reader, pair);
    return;
  }
  if (!number_is_due(reader, pair)) return;
  struct led_place* led = &reader->rig->leds[reader->due - 1];
  double numbers[5];
  if (!read_numbers(pair->value, numbers, 5) || !is_int(numbers[0]) || !is_int(numbers[1])) {
    rig_complain(reader->errors, pair->line, "'%s' needs chip, output, x, y, z: decimal numbers",
                 pair->key);
    return;
  }
  const int chip = (int)numbers[0], output = (int)numbers[1];
  double* d = led->direction;
  memcpy(d, numbers + 2, sizeof led->direction);
  if (!take_output(reader, pair, chip, output)) return;
  led->chip = (uint8_t)chip;
  led->output = (uint8_t)output;
  if (!(fabs(sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) - 1) < 1e-3)) {
    rig_complain(reader->errors, pair->line, "'%s' has a direction whose length is not 1",
                 pair->key);
  }
}

enum lam_status rig_parse_leds(const char* text, size_t length, struct rig* rig,
                               struct rig_errors* errors) {
  struct led_reader reader = {.rig = rig, .errors = errors};
  const size_t before = errors->count;
  errors->in_leds = true;
  if (!rig_text_each_pair(text, length, errors, take_led, &reader)) return LAM_BAD_INPUT;
  if (errors->count == before && reader.count == 0) {
    rig_complain(errors, 0, "missing key 'led.count': how many LEDs are listed");
  } else if (errors->count == before && reader.due != reader.count) {
    rig_complain(errors, reader.last_line,
                 "%zu LEDs are listed, and 'led.count' on line %d says %zu: was it cut off?",
                 reader.due, reader.count_line, reader.count);
  }
  if (errors->count > before) return LAM_BAD_INPUT;
  rig->led_count = reader.due;
  return LAM_OK;
}
