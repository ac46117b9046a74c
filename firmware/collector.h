// The collector: a thread of normal priority, off the sequencer's processor, that reads photographs
// off the cameras and keeps them. The sequencer hands shots over and never waits for it.
#ifndef LAMELLA_FIRMWARE_COLLECTOR_H
#define LAMELLA_FIRMWARE_COLLECTOR_H

#include <pthread.h>
#include <semaphore.h>
#include <stdbool.h>

#include "hal.h"
#include "roll.h"
#include "store.h"

struct collector {
  struct hal* hal;
  struct store* store;
  const struct roll* roll;
  bool runs;
  pthread_t thread;
  sem_t work, progress;  // posted by the sequencer, by the thread
  // Read and set as atomics, as C++ has no C11 ones:
  unsigned offered;  // shots that are over, of the burst
  unsigned done;     // photographs kept or dropped, of the burst
  unsigned kept;     // of these
  unsigned epoch;    // counts bursts, and ends of them
  unsigned idle_in;  // the newest epoch that the thread has seen: nothing of older ones goes on
  bool failed, stops;
  // No more than their readers are told:
  bool dropped[ROLL_MAX_SHOTS];  // valid for shots whose photographs are done
  char error[160];               // valid once it has failed
};

// Starts the thread. linux.cpu of the roll's rig file, where it is given, is left to the sequencer.
enum lam_status collector_start(struct collector* collector, struct hal* hal, struct store* store,
                                const struct rig* rig, const struct roll* roll);

// Ends it. False where a camera does not let go of a photograph within a second; it must not be
// touched again then.
bool collector_stop(struct collector* collector);

// Ends the burst for the collector: what is not kept yet never is. The store and the roll must be
// left alone until it is idle.
void collector_forget(struct collector* collector);
bool collector_is_idle(const struct collector* collector);
// Waits for that, longest_us at most; whether it came.
bool collector_wait_idle(struct collector* collector, double longest_us);

// A new burst. Only while idle, after the last one was forgotten.
void collector_begin(struct collector* collector);

// Shots below this number are over. Never blocks.
void collector_offer(struct collector* collector, unsigned shots);

// Waits until a photograph more is done, or longest_us at most. Never while edges are played.
void collector_wait(struct collector* collector, double longest_us);

unsigned collector_done(const struct collector* collector);
unsigned collector_kept(const struct collector* collector);

// A camera or the store has failed, and `error` says how: nothing more is read.
bool collector_has_failed(const struct collector* collector);

#endif
