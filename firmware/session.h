// One burst from request to photographs in the store. The only part that says when anything moves:
//
//   IDLE --request--> ARMED --work--> RUNNING --work--> IDLE
//   ARMED, RUNNING --abort--> IDLE     ARMED, RUNNING --failure--> FAULT --abort--> IDLE
#ifndef LAMELLA_FIRMWARE_SESSION_H
#define LAMELLA_FIRMWARE_SESSION_H

#include <stdbool.h>

#include "burst.h"
#include "hal.h"
#include "player.h"
#include "proto/link.pb.h"
#include "rig.h"
#include "safety.h"
#include "store.h"
#include "timeline.h"

struct session {
  const struct rig* rig;
  struct hal* hal;
  struct store* store;
  lamella_v1_RigState state;
  char fault[128];
  enum lam_part fault_part;
  const char* occupied;  // why no burst may begin now, for whoever asks; NULL: it may
  char refusal[160];     // why the last request or abort was refused
  uint64_t burst_id;     // of the newest burst; the store gives it
  bool stands_crossed;
  bool playing;  // within RUNNING: edges, then photographs
  unsigned collected;
  struct burst_plan plan;
  struct timeline timeline;
  struct player player;
  lamella_v1_BurstDone done;
  bool heart;         // level of the heartbeat's line
  bool has_news;      // BurstDone or FAULT that no host was told yet
  bool has_progress;  // a photograph more that no host was told of yet
};

void session_init(struct session* session, const struct rig* rig, struct hal* hal,
                  struct store* store);

bool session_may_go(lamella_v1_RigState from, lamella_v1_RigState to);

// Compiles the twenty steps and checks them; nothing moves yet. LAM_WRONG_STATE unless IDLE and
// without photographs held (or told to discard them), LAM_UNSAFE where the plan breaks a rule.
enum lam_status session_request_burst(struct session* session, bool discard_held);

// The same for given steps, at most BURST_MAX_STEPS.
enum lam_status session_request_steps(struct session* session, const struct burst_step steps[],
                                      size_t count, bool discard_held);

// Does the next piece of the burst: starts it, plays one edge, or fetches one photograph.
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
