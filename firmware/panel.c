#include "panel.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define ON \
  { 1, 0, 1, 0, 0 }
#define OFF \
  { 0, 0, 0, 0, 0 }
// A fault counts itself out: short flashes for as long as it lasts, as many beeps in three rounds.
#define FAULT_LIGHT(number) \
  { 250, 250, number, 2000, 0 }
#define FAULT_BUZZER(number) \
  { 250, 250, number, 2000, 3 }
// A refusal flashes long.
#define REFUSED_LIGHT(number) \
  { 750, 250, number, 1500, 0 }
#define REFUSED_BUZZER \
  { 600, 300, 2, 0, 1 }

const struct panel_entry kPanelTable[PANEL_CODES] = {
    [PANEL_STARTING] = {"starting", {1000, 1000, 1, 0, 0}, OFF, "the rig tests itself: wait"},
    [PANEL_READY] = {"ready", ON, OFF, "press the button for a burst; hold it to pair a host"},
    [PANEL_COUNTDOWN] = {"countdown",
                         {500, 500, 3, 0, 1},
                         {100, 900, 3, 0, 1},
                         "sit still; press again to call it off"},
    [PANEL_BURST] = {"burst", OFF, OFF, "photographs are taken: dark and silent, sit still"},
    [PANEL_STORING] = {"storing", {1750, 250, 1, 0, 0}, OFF, "the subject may move: wait"},
    [PANEL_GOOD] = {"good", ON, {600, 0, 1, 0, 1}, "the session is kept"},
    [PANEL_RETAKEN] = {"retaken", ON, {200, 200, 2, 0, 1}, "kept; some frames were taken twice"},
    [PANEL_MARKED] = {"marked",
                      {100, 400, 1, 0, 0},
                      {200, 200, 3, 0, 1},
                      "kept, but some frames are doubtful: take it again"},
    [PANEL_REFUSED_BUSY] = {"refused: busy", REFUSED_LIGHT(2), REFUSED_BUZZER,
                            "a host uses the rig: wait, or unplug it"},
    [PANEL_REFUSED_UNSAFE] = {"refused: unsafe", REFUSED_LIGHT(3), REFUSED_BUZZER,
                              "the rig file's burst breaks a rule: lamella rig plan says which"},
    [PANEL_REFUSED_FULL] = {"refused: full", REFUSED_LIGHT(4), REFUSED_BUZZER,
                            "no room for a session: connect a host and sync"},
    [PANEL_FAULT_ESTOP] = {"fault: e-stop", FAULT_LIGHT(1), FAULT_BUZZER(1),
                           "the emergency stop is pressed: release it, then press the button"},
    [PANEL_FAULT_HOT] = {"fault: hot", FAULT_LIGHT(2), FAULT_BUZZER(2),
                         "the LEDs are too hot: let them cool, then press the button"},
    [PANEL_FAULT_CAMERA] = {"fault: camera", FAULT_LIGHT(3), FAULT_BUZZER(3),
                            "a camera gives no frame: check its cable and power"},
    [PANEL_FAULT_ACTUATOR] = {"fault: actuator", FAULT_LIGHT(4), FAULT_BUZZER(4),
                              "the polarizer does not reach its end stops: free it"},
    [PANEL_FAULT_LED_CHAIN] =
        {"fault: LED chain", FAULT_LIGHT(5), FAULT_BUZZER(5),
         "LEDs, drivers or BLANK are wrong: lamella rig selftest --only blank chain leds"},
    [PANEL_FAULT_DISK] = {"fault: disk", FAULT_LIGHT(6), FAULT_BUZZER(6),
                          "the disk does not take photographs: check it, sync sessions off it"},
    [PANEL_FAULT_PROJECTOR] = {"fault: projector", FAULT_LIGHT(7), FAULT_BUZZER(7),
                               "the projector does not flip: check its cable and power"},
    [PANEL_FAULT_OTHER] = {"fault: other", FAULT_LIGHT(8), FAULT_BUZZER(8),
                           "lamella rig status says what it is"},
    [PANEL_PAIRING] = {"pairing",
                       {400, 100, 1, 0, 0},
                       {50, 1950, 1, 0, 0},
                       "the button is held: a host may pair with the rig"},
};

void panel_pattern_text(const struct panel_pattern* pattern, char text[64]) {
  const struct panel_pattern* p = pattern;
  if (p->count == 0 || (p->off_ms == 0 && p->rounds == 0)) {
    snprintf(text, 64, p->count == 0 ? "off" : "on");
    return;
  }
  char pause[24] = "", rounds[24] = "repeated";
  if (p->pause_ms > 0) snprintf(pause, sizeof pause, ", pause %u ms", (unsigned)p->pause_ms);
  if (p->rounds == 1) snprintf(rounds, sizeof rounds, "once");
  if (p->rounds > 1) snprintf(rounds, sizeof rounds, "%u rounds", (unsigned)p->rounds);
  snprintf(text, 64, "%u x %u/%u ms%s, %s", (unsigned)p->count, (unsigned)p->on_ms,
           (unsigned)p->off_ms, pause, rounds);
}

static double round_us(const struct panel_pattern* pattern) {
  return 1e3 * (pattern->count * ((double)pattern->on_ms + pattern->off_ms) + pattern->pause_ms);
}

double panel_pattern_length_us(const struct panel_pattern* pattern) {
  if (pattern->count == 0) return 0;
  return pattern->rounds == 0 ? INFINITY : pattern->rounds * round_us(pattern);
}

bool panel_pattern_level(const struct panel_pattern* pattern, double since_us) {
  if (since_us < 0 || since_us >= panel_pattern_length_us(pattern)) return false;
  if (pattern->off_ms == 0 && pattern->rounds == 0) return true;
  const double in_round_us = fmod(since_us, round_us(pattern));
  const double pulse_us = 1e3 * ((double)pattern->on_ms + pattern->off_ms);
  if (in_round_us >= pattern->count * pulse_us) return false;
  return fmod(in_round_us, pulse_us) < 1e3 * pattern->on_ms;
}

void panel_init(struct panel* panel, double now_us) {
  memset(panel, 0, sizeof *panel);
  panel->code = PANEL_STARTING;
  panel->since_us = now_us;
  panel->light_rose_us = -INFINITY;
  panel->raw_since_us = panel->down_since_us = now_us;
}

void panel_show(struct panel* panel, enum panel_code code, double now_us) {
  if (panel->code == code) return;
  panel->code = code;
  panel->since_us = now_us;
}

void panel_tick(struct panel* panel, double now_us) {
  const struct panel_entry* entry = &kPanelTable[panel->code];
  const double since_us = now_us - panel->since_us;
  const bool light = panel_pattern_level(&entry->light, since_us);
  const bool rises = light && !panel->light;
  panel->buzzer = panel_pattern_level(&entry->buzzer, since_us);
  if (rises && now_us - panel->light_rose_us < PANEL_LEAST_FLASH_US) return;
  if (rises) panel->light_rose_us = now_us;
  panel->light = light;
}

enum panel_event panel_feel(struct panel* panel, bool pressed, double now_us) {
  if (pressed != panel->raw) {
    panel->raw = pressed;
    panel->raw_since_us = now_us;
  }
  const bool steady = now_us - panel->raw_since_us >= PANEL_DEBOUNCE_US;
  if (steady && panel->raw != panel->down) {
    panel->down = panel->raw;
    if (panel->down) {
      panel->down_since_us = panel->raw_since_us;
      return PANEL_NOTHING;
    }
    const bool was_held = panel->held;
    panel->held = false;
    return was_held ? PANEL_RELEASED : PANEL_CLICKED;
  }
  if (panel->down && !panel->held && now_us - panel->down_since_us >= PANEL_HOLD_US) {
    panel->held = true;
    return PANEL_HELD;
  }
  return PANEL_NOTHING;
}
