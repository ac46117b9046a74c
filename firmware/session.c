#include "session.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "budget.h"
#include "complain.h"
#include "latency.h"
#include "led_driver.h"
#include "session_inside.h"
#include "verdict.h"

enum { kDiskWaitMs = 20 };  // hosts are heard between

#define STATE(name) lamella_v1_RigState_##name

static const double kCollectUs = 20e3;  // and so long for a photograph
static const double kLetGoUs = 1e6;     // a camera lets go of a forgotten photograph by then

void session_init(struct session* session, const struct rig* rig, struct hal* hal,
                  struct store* store) {
  memset(session, 0, sizeof *session);
  session->rig = rig;
  session->hal = hal;
  session->store = store;
  session->state = STATE(IDLE);
  session->stands_crossed = rig->analyser_parks_crossed;
  session->burst_id = store->last_burst_id;
}

void session_test_latency(struct session* session) {
  latency_test(session->hal, &session->latency);
}

bool session_may_go(lamella_v1_RigState from, lamella_v1_RigState to) {
  switch (from) {
    case STATE(IDLE):
      return to == STATE(ARMED);
    case STATE(ARMED):
      return to == STATE(RUNNING) || to == STATE(IDLE) || to == STATE(FAULT);
    case STATE(RUNNING):
      return to == STATE(IDLE) || to == STATE(FAULT);
    case STATE(FAULT):
      return to == STATE(IDLE);
    default:
      return false;
  }
}

bool session_is_busy(const struct session* session) {
  return session->state == STATE(ARMED) || session->state == STATE(RUNNING);
}

static enum lam_status refuse(struct session* session, enum lam_status status, const char* why) {
  snprintf(session->refusal, sizeof session->refusal, "%s", why);
  return status;
}

static enum lam_status go(struct session* session, lamella_v1_RigState to) {
  if (!session_may_go(session->state, to)) {
    return refuse(session, LAM_WRONG_STATE, "the rig cannot do this from the state it is in");
  }
  session->state = to;
  return LAM_OK;
}

const struct burst_plan* session_plan(const struct session* session) {
  return &session->roll.takes[0].plan;
}

void session_timing(const struct session* session, uint32_t first_edge,
                    lamella_v1_TimingEdges* page) {
  const size_t room = sizeof page->edges / sizeof page->edges[0];
  const size_t total = roll_edge_count(&session->roll);
  *page = (lamella_v1_TimingEdges){.zero_us = session->roll.takes[0].player.zero_us,
                                   .has_latency = true,
                                   .latency = session->latency,
                                   .first_edge = first_edge,
                                   .total_edges = (uint32_t)total};
  for (size_t i = first_edge; i < total && page->edges_count < room; i++) {
    roll_describe_edge(&session->roll, i, &page->edges[page->edges_count++]);
  }
}

static void give_timing(const void* session, uint32_t first_edge, lamella_v1_TimingEdges* page) {
  session_timing(session, first_edge, page);
}

static enum lam_status end_in_store(struct session* session, const char* why) {
  const struct store_ending ending = {
      .why = why, .done = session->done, .timing = give_timing, .context = session};
  return store_end(session->store, &ending);
}

// A burst that is not whole ends in the store once nobody else touches that.
static bool settle(struct session* session) {
  if (session->ends_unwhole == NULL) return true;
  if (!collector_is_idle(&session->collector)) return false;
  end_in_store(session, session->ends_unwhole);
  session->ends_unwhole = NULL;
  return true;
}

static bool await_end(struct session* session) {
  if (session->ends_unwhole == NULL) return false;
  collector_wait_idle(&session->collector, kCollectUs);
  settle(session);
  return true;
}

static void end_unwhole(struct session* session, const char* why) {
  session->playing = false;
  session->ends_unwhole = why;
  collector_forget(&session->collector);
  collector_wait_idle(&session->collector, kCollectUs);
  settle(session);
}

void session_close(struct session* session) {
  session->hal->lights_off(session->hal->self);
  if (session_is_busy(session)) {
    session->ends_unwhole = "the rig was stopped";
  }
  if (collector_stop(&session->collector)) settle(session);
}

bool session_fail(struct session* session, enum lam_part part, const char* why) {
  session->fault_part = part;
  session->hal->lights_off(session->hal->self);
  snprintf(session->fault, sizeof session->fault, "%s", why);
  end_unwhole(session, session->fault);
  complain("lamella-rigd: burst %llu: FAULT: %s", (unsigned long long)session->burst_id, why);
  session->has_news = go(session, STATE(FAULT)) == LAM_OK;
  return true;
}

bool session_fail_by_collector(struct session* session) {
  const bool disk = store_fault(session->store)[0] != '\0';
  return session_fail(session, disk ? LAM_PART_DISK : LAM_PART_CAMERA, session->collector.error);
}

// A plan that breaks no rule, or the reason why there is none.
static enum lam_status compile(struct session* session, const struct burst_step steps[],
                               size_t count, struct burst_plan* plan, struct timeline* timeline) {
  struct safety_finding finding;
  struct budget budget;
  burst_order(session->rig, steps, count, session->stands_crossed, plan);
  timeline_build(session->rig, plan, timeline);
  if (safety_check(session->rig, timeline, &finding) != LAM_OK) {
    return refuse(session, LAM_UNSAFE, finding.text);
  }
  if (budget_check(session->rig, plan, &budget) != LAM_OK) {
    return refuse(session, LAM_UNSAFE, budget.refusal);
  }
  if (session->flashing_unconfirmed && budget.flashes_per_s > BUDGET_HARMLESS_FLASHES_PER_S) {
    char why[160];
    snprintf(why, sizeof why,
             "%.0f flashes in a second: more than %d need the operator's word that this subject "
             "bears them (capture --flashing-confirmed)",
             budget.flashes_per_s, BUDGET_HARMLESS_FLASHES_PER_S);
    return refuse(session, LAM_UNSAFE, why);
  }
  return LAM_OK;
}

// The collector runs, and has let go of the last burst.
static enum lam_status free_collector(struct session* session) {
  struct collector* collector = &session->collector;
  if (!collector->runs && collector_start(collector, session->hal, session->store, session->rig,
                                          &session->roll) != LAM_OK) {
    return refuse(session, LAM_WRONG_STATE, "no thread can be had to collect photographs");
  }
  collector_forget(collector);
  if (!collector_wait_idle(collector, kLetGoUs) || !settle(session)) {
    return refuse(session, LAM_WRONG_STATE, "a camera still reads for the burst before: try again");
  }
  collector_begin(collector);
  return LAM_OK;
}

static enum lam_status refuse_unfit(struct session* session) {
  snprintf(session->refusal, sizeof session->refusal,
           "self-test: %.110s; mend it, then: lamella rig selftest", session->unfit);
  return LAM_HARDWARE;
}

enum lam_status session_request_steps(struct session* session, const struct burst_step steps[],
                                      size_t count, bool discard_held) {
  if (session->state != STATE(IDLE)) {
    return refuse(session, LAM_WRONG_STATE,
                  session->state == STATE(FAULT) ? "the rig is in FAULT: abort clears it"
                                                 : "a burst is under way");
  }
  if (session->occupied != NULL) return refuse(session, LAM_WRONG_STATE, session->occupied);
  if (session->unfit[0] != '\0') return refuse_unfit(session);
  struct burst_plan plan;
  struct timeline timeline;
  enum lam_status status = compile(session, steps, count, &plan, &timeline);
  if (status == LAM_OK) status = free_collector(session);
  if (status != LAM_OK) return status;
  const struct store_order order = {.frames = (uint32_t)(2 * count),
                                    .frame_bytes = session->rig->camera_frame_bytes,
                                    .discard_held = discard_held,
                                    .flashing_confirmed = !session->flashing_unconfirmed,
                                    .subject = session->subject};
  status = store_begin(session->store, &order, &session->burst_id, session->refusal,
                       sizeof session->refusal);
  if (status != LAM_OK) return status;
  session->ends_with_host = false;
  roll_begin(&session->roll, session->rig);
  roll_add_take(&session->roll, &plan, &timeline);
  return go(session, STATE(ARMED));
}

enum lam_status session_request_burst(struct session* session, bool discard_held) {
  return session_request_steps(session, kBurstSteps, BURST_STEPS, discard_held);
}

static bool start(struct session* session) {
  struct take* take = roll_newest_take(&session->roll);
  session->retake.why_not[0] = '\0';
  session->offered = session->told = 0;
  struct led_functions functions;
  if (led_driver_ready(session->hal, session->rig, &functions) != LAM_OK) {
    return session_fail(session, LAM_PART_LED_CHAIN, session->hal->error);
  }
  if (player_start(&take->player, session->hal, session->rig, &take->plan, &take->timeline) !=
      LAM_OK) {
    return session_fail(session, LAM_PART_OTHER, session->hal->error);
  }
  session->playing = true;
  return go(session, STATE(RUNNING)) == LAM_OK;
}

static enum lam_part part_behind(enum edge_line line) {
  if (line == EDGE_SHIFT) return LAM_PART_LED_CHAIN;
  if (line == EDGE_COMMIT) return LAM_PART_PROJECTOR;
  return line == EDGE_ANALYSER ? LAM_PART_ACTUATOR : LAM_PART_OTHER;
}

// Gives the collector what is over: at once where the hardware reads while edges are played.
static void offer(struct session* session, unsigned shots) {
  if (shots == session->offered) return;
  session->offered = shots;
  collector_offer(&session->collector, shots);
}

static void offer_played(struct session* session) {
  if (!session->hal->reads_while_playing) return;
  const struct take* take = roll_newest_take(&session->roll);
  unsigned shots = session->offered;
  while (shots < session->roll.shot_count &&
         player_step_is_over(&take->player, session->roll.shots[shots].step)) {
    shots++;
  }
  offer(session, shots);
}

static bool play(struct session* session) {
  struct take* take = roll_newest_take(&session->roll);
  struct player* player = &take->player;
  const struct edge* edge = &take->timeline.edges[player->next];
  if (player_step(player) != LAM_OK) {
    return session_fail(session, part_behind(edge->line), session->hal->error);
  }
  if (edge->line == EDGE_ANALYSER) session->stands_crossed = edge->value;
  session->playing = !player_is_done(player);
  offer_played(session);
  return true;
}

static bool collect(struct session* session) {
  collector_wait(&session->collector, kCollectUs);
  return true;
}

static bool give_up_retake(struct session* session, const char* why) {
  snprintf(session->retake.why_not, sizeof session->retake.why_not, "%s", why);
  return false;
}

// Another take of what went wrong, where there is some and there is time.
static bool retake(struct session* session) {
  struct roll* roll = &session->roll;
  struct hal* hal = session->hal;
  for (size_t i = 0; 2 * (i + 1) <= collector_done(&session->collector); i++) {
    roll->shots[i].dropped = session->collector.dropped[i];
  }
  roll_judge(roll);
  if (!retake_find(roll, session->stands_crossed, hal->now_us(hal->self), &session->retake)) {
    return false;
  }
  if (!store_has_room(session->store, (uint32_t)(2 * session->retake.plan.count),
                      session->rig->camera_frame_bytes)) {
    return give_up_retake(session, "the disk has no room");
  }
  hal->wait_until_us(hal->self, session->retake.rest_us);
  struct take* take = roll_add_take(roll, &session->retake.plan, &session->retake.timeline);
  if (player_resume(&take->player, hal, session->rig, &take->plan, &take->timeline) != LAM_OK) {
    return session_fail(session, LAM_PART_OTHER, hal->error);
  }
  const double end_us = roll_zero_us(roll, roll->take_count - 1) + take->plan.duration_us;
  if (end_us > session->rig->burst_longest_us) {
    roll_withdraw_take(roll);
    return give_up_retake(session, "the rig came to rest too late");
  }
  roll_replace(roll);
  session->playing = true;
  return true;
}

static bool finish(struct session* session) {
  if (!store_is_written(session->store, kDiskWaitMs)) {
    session->has_progress = true;
    return true;
  }
  const struct roll* roll = &session->roll;
  for (size_t i = 0; i < 2 * roll->shot_count; i++) {
    const struct shot* shot = &roll->shots[i / 2];
    if (!shot->bad && shot->replaced_by < 0) continue;
    store_mark(session->store, (uint32_t)i, shot->bad, shot->replaced_by);
  }
  verdict_write(roll, collector_kept(&session->collector), session->retake.why_not, &session->done);
  session->done.burst_id = session->burst_id;
  if (end_in_store(session, NULL) != LAM_OK) {
    return session_fail(session, LAM_PART_DISK, store_fault(session->store));
  }
  complain("lamella-rigd: burst %llu: %s", (unsigned long long)session->burst_id,
           session->done.verdict);
  session->has_news = true;
  return go(session, STATE(IDLE)) == LAM_OK;
}

static void note_progress(struct session* session) {
  const unsigned kept = collector_kept(&session->collector);
  session->has_progress = session->has_progress || kept > session->told;
  session->told = kept;
}

bool session_work(struct session* session) {
  if (session->state == STATE(ARMED)) return start(session);
  if (session->state != STATE(RUNNING)) return await_end(session);
  note_progress(session);
  if (collector_has_failed(&session->collector)) return session_fail_by_collector(session);
  if (store_fault(session->store)[0] != '\0') {
    return session_fail(session, LAM_PART_DISK, store_fault(session->store));
  }
  if (session->playing) return play(session);
  if (collector_done(&session->collector) < 2 * session->offered) return collect(session);
  if (retake(session) || session->state != STATE(RUNNING)) return true;
  if (session->offered == session->roll.shot_count) return finish(session);
  offer(session, (unsigned)session->roll.shot_count);
  return true;
}

double session_slack_us(const struct session* session) {
  return session->playing
             ? player_slack_us(&session->roll.takes[session->roll.take_count - 1].player)
             : INFINITY;
}

enum lam_status session_abort(struct session* session) {
  session->hal->lights_off(session->hal->self);
  if (session->state == STATE(IDLE)) {
    return refuse(session, LAM_WRONG_STATE, "there is no burst to abort");
  }
  if (session->state != STATE(FAULT)) end_unwhole(session, "aborted by the operator");
  if (session->ends_unwhole != NULL) session->ends_unwhole = "aborted by the operator";
  session->has_news = session->has_progress = false;
  session->fault[0] = '\0';
  return go(session, STATE(IDLE));
}

void session_status(const struct session* session, lamella_v1_Status* status) {
  *status = (lamella_v1_Status){.state = session->state,
                                .burst_id = session->burst_id,
                                .frames_held = (uint32_t)store_held(session->store),
                                .bursts_held = store_bursts_held(session->store),
                                .has_latency = true,
                                .latency = session->latency};
  snprintf(status->fault, sizeof status->fault, "%s", session->fault);
}
