// One burst from request to photographs in the store. The only part that says when anything moves:
//
//   IDLE --request--> ARMED --work--> RUNNING --work--> IDLE
//   ARMED, RUNNING --abort--> IDLE     ARMED, RUNNING --failure--> FAULT --abort--> IDLE
//
// RUNNING, a burst plays a take; its photographs are collected meanwhile or after it, as the
// hardware can; what went wrong is played again in another take while burst.longest_us allows.
#ifndef LAMELLA_FIRMWARE_SESSION_H
#define LAMELLA_FIRMWARE_SESSION_H

#include <stdbool.h>

#include "burst.h"
#include "collector.h"
#include "hal.h"
#include "player.h"
#include "proto/link.pb.h"
#include "retake.h"
#include "rig.h"
#include "roll.h"
#include "safety.h"
#include "store.h"

struct session {
  const struct rig* rig;
  struct hal* hal;
  struct store* store;
  lamella_v1_RigState state;
  char fault[128];
  enum lam_part fault_part;
  const char* occupied;  // why no burst may begin now, for whoever asks; NULL: it may
  char unfit[128];       // why no burst may begin before the rig is mended; "": it may
  char refusal[160];     // why the last request or abort was refused
  uint64_t burst_id;     // of the newest burst; the store gives it
  bool stands_crossed;
  bool ends_with_host;   // the burst, where its host is gone while edges are played
  double host_heard_us;  // when it last asked for something
  bool playing;          // within RUNNING: edges of the newest take
  struct roll roll;
  struct retake retake;
  struct collector collector;
  unsigned offered;            // shots that the collector was given
  unsigned told;               // photographs that has_progress was set for
  const char* ends_unwhole;    // why the burst ends in the store once the collector is idle
  lamella_v1_Latency latency;  // of this daemon
  lamella_v1_BurstDone done;
  bool flashing_unconfirmed;  // nobody has said that this subject bears flashing light
  const char* subject;        // of the burst that is asked for; NULL: nobody named one
  bool has_news;              // BurstDone or FAULT that no host was told yet
  bool has_progress;          // a photograph more that no host was told of yet
};

// The session stays where it is until it is closed.
void session_init(struct session* session, const struct rig* rig, struct hal* hal,
                  struct store* store);

// Ends what reads photographs. The hardware is closed after it.
void session_close(struct session* session);

// Measures how late waits end on this machine, and how long a line takes to move (latency.h).
void session_test_latency(struct session* session);

bool session_may_go(lamella_v1_RigState from, lamella_v1_RigState to);

// A burst is under way: ARMED or RUNNING.
bool session_is_busy(const struct session* session);

// Compiles the twenty steps and checks them; nothing moves yet. LAM_WRONG_STATE unless IDLE and
// without photographs held (or told to discard them), LAM_UNSAFE where the plan breaks a rule,
// LAM_HARDWARE while the rig is unfit or its disk takes no burst.
enum lam_status session_request_burst(struct session* session, bool discard_held);

// The same for given steps, at most BURST_MAX_STEPS.
enum lam_status session_request_steps(struct session* session, const struct burst_step steps[],
                                      size_t count, bool discard_held);

// The burst just begun ends, lights off, where its host is gone: session_lose_host() says so, or
// session_hear_host() is not called for 500 ms while edges are played.
void session_tie_to_host(struct session* session);
void session_hear_host(struct session* session);
void session_lose_host(struct session* session);

// The plan of the burst: of its first take.
const struct burst_plan* session_plan(const struct session* session);

// Does the next piece of the burst: starts a take, plays one edge, or looks after the photographs.
// False where there is nothing to do. The end of a burst, good or bad, is also a line on stderr.
bool session_work(struct session* session);

// For the gaps of a burst, some hundred times a second: the heart beats, and what the inputs say,
// or a full disk, may end the burst in FAULT with the lights off. Does nothing while none is
// played.
void session_watch(struct session* session);

// While edges are played: time until the next one. Infinite otherwise.
double session_slack_us(const struct session* session);

// Lights off first. LAM_WRONG_STATE while IDLE.
enum lam_status session_abort(struct session* session);

// Some of the burst's edges, from `first_edge` on, as planned and as they happened.
void session_timing(const struct session* session, uint32_t first_edge,
                    lamella_v1_TimingEdges* page);

void session_status(const struct session* session, lamella_v1_Status* status);

#endif
