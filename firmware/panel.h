// The operator's panel: one button, the ready light and the buzzer. What they say is data, a
// pattern in time for each code; README.md has the same table for people. No hardware here.
#ifndef LAMELLA_FIRMWARE_PANEL_H
#define LAMELLA_FIRMWARE_PANEL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum panel_code {
  PANEL_STARTING,
  PANEL_READY,
  PANEL_COUNTDOWN,
  PANEL_BURST,
  PANEL_STORING,
  PANEL_GOOD,
  PANEL_RETAKEN,
  PANEL_MARKED,
  PANEL_REFUSED_BUSY,
  PANEL_REFUSED_UNSAFE,
  PANEL_REFUSED_FULL,
  PANEL_FAULT_ESTOP,
  PANEL_FAULT_HOT,
  PANEL_FAULT_CAMERA,
  PANEL_FAULT_ACTUATOR,
  PANEL_FAULT_LED_CHAIN,
  PANEL_FAULT_DISK,
  PANEL_FAULT_PROJECTOR,
  PANEL_FAULT_OTHER,
  PANEL_PAIRING,
  PANEL_CODES,
};

// `count` pulses and a pause make a round. No pulse: off for good. A pulse without an end (off_ms
// 0): on for good.
struct panel_pattern {
  uint16_t on_ms, off_ms;
  uint8_t count;
  uint16_t pause_ms;
  uint8_t rounds;  // 0: for as long as the code is shown
};

struct panel_entry {
  const char* name;  // "fault: camera"
  struct panel_pattern light, buzzer;
  const char* meaning;  // and what to do, in one line
};

extern const struct panel_entry kPanelTable[PANEL_CODES];

// "2 x 250/250 ms, pause 2000 ms, 3 rounds", as in README.md; `text` has room for 64 characters.
void panel_pattern_text(const struct panel_pattern* pattern, char text[64]);

bool panel_pattern_level(const struct panel_pattern* pattern, double since_us);
// How long one showing lasts; infinite where it has no end.
double panel_pattern_length_us(const struct panel_pattern* pattern);

enum panel_event {
  PANEL_NOTHING,
  PANEL_CLICKED,   // pressed, and let go before it counts as held
  PANEL_HELD,      // held for PANEL_HOLD_US, still down
  PANEL_RELEASED,  // let go after that
};

// A button bounces for some milliseconds; nobody presses for less than this.
#define PANEL_DEBOUNCE_US 30e3
#define PANEL_HOLD_US 3e6
// Flashes of light above 3 a second can harm: the light never rises sooner than this again.
#define PANEL_LEAST_FLASH_US 334e3

struct panel {
  enum panel_code code;
  double since_us;  // the code is shown since then
  bool light, buzzer;
  double light_rose_us;
  bool raw, down, held;
  double raw_since_us, down_since_us;
};

void panel_init(struct panel* panel, double now_us);

// Shows a code from its pattern's beginning; the code that is shown already goes on.
void panel_show(struct panel* panel, enum panel_code code, double now_us);

// Brings `light` and `buzzer` to what they are now.
void panel_tick(struct panel* panel, double now_us);

// Takes the button's line as it is now, as often as can be. One event at a time.
enum panel_event panel_feel(struct panel* panel, bool pressed, double now_us);

#endif
