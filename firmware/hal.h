// The only door to hardware. Times are microseconds on the rig's monotonic clock. Every call that
// moves something says when it really happened; a call that fails leaves its reason in `error`.
#ifndef LAMELLA_FIRMWARE_HAL_H
#define LAMELLA_FIRMWARE_HAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "led_chain.h"
#include "proto/twin.pb.h"
#include "status.h"

enum hal_line {
  HAL_BLANK,  // 1: LED outputs off. Pulled up, and requested with 1
  HAL_LATCH,  // rising: the shifted codes become the outputs' codes
  // Both cameras: they integrate while it is 1, start_delay later. Which level of the line that is
  // says the rig file (camera.trigger_active).
  HAL_TRIGGER,
  HAL_LAMP,       // 0: the projector's lamp is shuttered
  HAL_HEARTBEAT,  // each edge re-arms the monostable that holds BLANK up by itself
  HAL_READY,      // the operator's light
  HAL_BUZZER,
  HAL_LINES,
};

// What the rig's inputs say. A rig without an input says the harmless thing.
struct hal_senses {
  bool start_pressed;            // its line is 1
  bool estopped;                 // its line is 0, so that a broken wire stops too: no LED supply
  bool at_parallel, at_crossed;  // the actuator's end stops
  bool stuck;                    // it moves for half as long again as a move takes
  double hottest_c;              // of the thermistors; NaN where there are none
};

// What is told of an actuator that is.
#define HAL_STUCK "the analyser's actuator has not reached its end stop: is it stuck?"

// An edge of BLANK or TRIGGER as a loop-back input saw it, by the kernel's own time.
struct hal_seen_edge {
  enum hal_line line;
  bool level;
  double at_us;
};

struct hal_pattern {
  lamella_v1_PatternSpan_Kind kind;
  uint8_t index;
};

// A photograph as the sensor gave it. `bytes` is the caller's room of `capacity` bytes. A reading
// that fails leaves its reason here: it has a thread of its own.
struct hal_photograph {
  uint8_t* bytes;
  size_t capacity;
  lamella_v1_PhotographHeader header;
  char error[160];
};

struct hal {
  const char* name;  // "sim"
  void* self;        // first argument of every call
  char error[160];   // of the thread that plays; read_photograph's reason is the photograph's
  bool heart;        // level of the heartbeat's line
  // read_photograph may be called by another thread while edges are played.
  bool reads_while_playing;
  // wait_until_us() takes real time: who waits long sleeps by himself, where a signal can end it.
  bool keeps_real_time;
  bool sees_trigger;  // a loop-back input does: next_seen() tells of each of its edges
  double lead_us;     // from set_line() to the line's move, as latency.h measured it; 0 until then
  // The kernel's timer interrupts the player at tick_at_us and every tick_us before and after; 0:
  // never.
  double tick_us, tick_at_us;

  double (*now_us)(void* self);
  // Sleeps to just before t_us and spins to it; at once where t_us has passed. Returns the time.
  double (*wait_until_us)(void* self, double t_us);

  // Lights off, analyser at rest, nothing photographed yet; returns at a vblank of the projector,
  // which becomes the burst's zero.
  enum lam_status (*prepare)(void* self, double* zero_us);
  // Of that all but the wait for the analyser and the vblank: for what needs neither.
  enum lam_status (*arm)(void* self);
  // The same for another timeline of the same burst: what was photographed is kept, shots count on.
  enum lam_status (*resume)(void* self, double* zero_us);
  enum lam_status (*set_line)(void* self, enum hal_line line, bool level, double* at_us);
  // Returns when the last bit is in the chain; BLANK must be 1. `pushed_out`, where it is not NULL,
  // gets the bits that left the far end meanwhile: what the chain held before.
  enum lam_status (*shift_leds)(void* self, const uint8_t stream[CHAIN_BYTES],
                                uint8_t pushed_out[CHAIN_BYTES], double* at_us);
  // Shows the pattern from the next vblank on; `flipped` becomes true then, once, and says when.
  enum lam_status (*commit_pattern)(void* self, struct hal_pattern pattern, double* at_us);
  bool (*flipped)(void* self, double* at_us);
  // Starts the left camera's analyser towards crossed (or parallel); `arrived` as `flipped`.
  enum lam_status (*move_analyser)(void* self, bool crossed, double* at_us);
  bool (*arrived)(void* self, double* at_us);
  // The photograph that trigger pulse number `shot` since prepare() took with one camera.
  // LAM_DROPPED where the camera did not take it. Called by one thread, not always the player's.
  enum lam_status (*read_photograph)(void* self, unsigned shot, unsigned camera,
                                     struct hal_photograph* photograph);
  // The oldest edge that a loop-back saw and nobody has asked for yet; false where there is none.
  bool (*next_seen)(void* self, struct hal_seen_edge* edge);
  // Quick enough for the gap between two edges.
  enum lam_status (*sense)(void* self, struct hal_senses* senses);
  void (*lights_off)(void* self);  // and HAL_TRIGGER 0
  void (*close)(void* self);
};

// Re-arms the monostable, for as long as that holds: to be called while light may shine, and
// shortly before.
static inline enum lam_status hal_beat(struct hal* hal) {
  double at_us = 0;
  hal->heart = !hal->heart;
  return hal->set_line(hal->self, HAL_HEARTBEAT, hal->heart, &at_us);
}

#endif
