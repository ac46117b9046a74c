// The rig file: every number of one rig, `key = value`, one a line, units in the keys. The LEDs are
// listed in a second file, as many rigs share a dome.
#ifndef LAMELLA_FIRMWARE_RIG_H
#define LAMELLA_FIRMWARE_RIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "rig_camera.h"
#include "rig_linux.h"
#include "rig_text.h"
#include "status.h"

enum { RIG_MAX_LEDS = 168, RIG_MOST_PROJECTOR_PX = 4096 };
enum { PATTERN_FRINGES = 4, PATTERN_STRIPES = 4 };  // of a burst

struct led_place {
  uint8_t chip;         // 0 is nearest to the board
  uint8_t output;       // 0 to 23
  double direction[3];  // unit, rig frame, from the subject towards the LED
};

// A field for every key of rig_keys.def: `leds.spi_hz` is the double leds_spi_hz.
struct rig {
#define NUMBER(section, name, lowest, highest) double section##_##name;
#define OPTIONAL_NUMBER(section, name, lowest, highest, otherwise) double section##_##name;
#define PLACED_NUMBER(section, name, field, lowest, highest)
#define WHOLE(section, name, lowest, highest) double section##_##name;
#define CHOICE(section, name, field, no, yes) bool field;
#define TEXT(section, name) char section##_##name[RIG_TEXT_CHARS];
#include "rig_keys.def"
#undef NUMBER
#undef OPTIONAL_NUMBER
#undef PLACED_NUMBER
#undef WHOLE
#undef CHOICE
#undef TEXT
  double pattern_fringe_periods[PATTERN_FRINGES];
  struct rig_linux board;
  struct rig_camera sensor;  // of each camera; only of a board that has cameras
  size_t led_count;
  struct led_place leds[RIG_MAX_LEDS];
};

// Reads a rig file's text; the rig has no LEDs yet. On LAM_BAD_INPUT `errors` says of every wrong
// key which line, why and what to do. Begins a new list.
enum lam_status rig_parse(const char* text, size_t length, struct rig* rig,
                          struct rig_errors* errors);

// Reads the text of the file that leds.file names: `led.count = LEDS`, `led.N = chip output x y z`.
// Adds to `errors`.
enum lam_status rig_parse_leds(const char* text, size_t length, struct rig* rig,
                               struct rig_errors* errors);

// Reads a rig file and the list of LEDs that it names, which lies beside it. On LAM_BAD_INPUT
// everything that is wrong with either is a line on stderr: "FILE:LINE: what".
enum lam_status rig_read(const char* path, struct rig* rig);

double rig_pwm_period_us(const struct rig* rig);  // 4096 greyscale clocks
double rig_refresh_us(const struct rig* rig);     // of the projector
// Of the LEDs' board, above which no light is allowed: a junction is hotter by what a lit LED heats
// itself.
double rig_hottest_board_c(const struct rig* rig);
double rig_projector_light_us(const struct rig* rig);  // whole refresh periods
double rig_shift_us(const struct rig* rig);            // all bits of the driver chain over SPI

#endif
