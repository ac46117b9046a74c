#include "session.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "budget.h"

enum { kDiskWaitMs = 20 };  // hosts are heard between

#define STATE(name) lamella_v1_RigState_##name

void session_init(struct session* session, const struct rig* rig, struct hal* hal,
                  struct store* store) {
  memset(session, 0, sizeof *session);
  session->rig = rig;
  session->hal = hal;
  session->store = store;
  session->state = STATE(IDLE);
  session->stands_crossed = rig->analyser_parks_crossed;
  session->burst_id = store_newest_burst(store);
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

void session_timing(const struct session* session, uint32_t first_edge,
                    lamella_v1_TimingEdges* page) {
  const size_t room = sizeof page->edges / sizeof page->edges[0];
  *page = (lamella_v1_TimingEdges){.zero_us = session->player.zero_us,
                                   .first_edge = first_edge,
                                   .total_edges = (uint32_t)session->timeline.count};
  for (size_t i = first_edge; i < session->timeline.count && page->edges_count < room; i++) {
    const struct edge* edge = &session->timeline.edges[i];
    lamella_v1_TimedEdge* timed = &page->edges[page->edges_count++];
    timed->planned_us = edge->t_us;
    timed->actual_us = session->player.played[i].actual_us;
    timed->tolerance_us = edge->tolerance_us;
    snprintf(timed->line, sizeof timed->line, "%s", timeline_line_name(edge->line));
    timed->value = edge->value;
    timed->step = edge->step;
  }
}

static void give_timing(const void* session, uint32_t first_edge, lamella_v1_TimingEdges* page) {
  session_timing(session, first_edge, page);
}

// Ends the burst in the store: whole, or with the reason why it is not.
static enum lam_status end_in_store(struct session* session, const char* why) {
  const struct store_ending ending = {
      .why = why, .done = session->done, .timing = give_timing, .context = session};
  return store_end(session->store, &ending);
}

static bool fail(struct session* session, enum lam_part part, const char* why) {
  session->fault_part = part;
  session->hal->lights_off(session->hal->self);
  snprintf(session->fault, sizeof session->fault, "%s", why);
  end_in_store(session, session->fault);
  fprintf(stderr, "lamella-rigd: burst %llu: FAULT: %s\n", (unsigned long long)session->burst_id,
          why);
  session->playing = false;
  session->has_news = go(session, STATE(FAULT)) == LAM_OK;
  return true;
}

enum lam_status session_request_steps(struct session* session, const struct burst_step steps[],
                                      size_t count, bool discard_held) {
  if (session->state != STATE(IDLE)) {
    return refuse(session, LAM_WRONG_STATE,
                  session->state == STATE(FAULT) ? "the rig is in FAULT: abort clears it"
                                                 : "a burst is under way");
  }
  if (session->occupied != NULL) return refuse(session, LAM_WRONG_STATE, session->occupied);
  struct safety_finding finding;
  burst_order(session->rig, steps, count, session->stands_crossed, &session->plan);
  timeline_build(session->rig, &session->plan, &session->timeline);
  if (safety_check(session->rig, &session->timeline, &finding) != LAM_OK) {
    return refuse(session, LAM_UNSAFE, finding.text);
  }
  struct budget budget;
  if (budget_check(session->rig, &session->plan, &budget) != LAM_OK) {
    return refuse(session, LAM_UNSAFE, budget.refusal);
  }
  const struct store_order order = {.frames = (uint32_t)(2 * count),
                                    .frame_bytes = session->rig->camera_frame_bytes,
                                    .discard_held = discard_held};
  const enum lam_status stored = store_begin(session->store, &order, &session->burst_id,
                                             session->refusal, sizeof session->refusal);
  return stored == LAM_OK ? go(session, STATE(ARMED)) : stored;
}

enum lam_status session_request_burst(struct session* session, bool discard_held) {
  return session_request_steps(session, kBurstSteps, BURST_STEPS, discard_held);
}

static bool start(struct session* session) {
  if (player_start(&session->player, session->hal, session->rig, &session->plan,
                   &session->timeline) != LAM_OK) {
    return fail(session, LAM_PART_OTHER, session->hal->error);
  }
  session->playing = true;
  session->collected = 0;
  return go(session, STATE(RUNNING)) == LAM_OK;
}

static enum lam_part part_behind(enum edge_line line) {
  if (line == EDGE_SHIFT) return LAM_PART_LED_CHAIN;
  if (line == EDGE_COMMIT) return LAM_PART_PROJECTOR;
  return line == EDGE_ANALYSER ? LAM_PART_ACTUATOR : LAM_PART_OTHER;
}

static bool play(struct session* session) {
  const struct edge* edge = &session->timeline.edges[session->player.next];
  if (player_step(&session->player) != LAM_OK) {
    return fail(session, part_behind(edge->line), session->hal->error);
  }
  if (edge->line == EDGE_ANALYSER) session->stands_crossed = edge->value;
  session->playing = !player_is_done(&session->player);
  return true;
}

// The junctions are hotter than the board by what a lit LED heats itself.
static double hottest_board_c(const struct rig* rig) {
  return rig->leds_highest_junction_c - rig->leds_power_w * rig->leds_thermal_k_per_w;
}

void session_watch(struct session* session) {
  if (!session->playing) return;
  struct hal* hal = session->hal;
  struct hal_senses senses;
  double at_us = 0;
  session->heart = !session->heart;
  if (hal->set_line(hal->self, HAL_HEARTBEAT, session->heart, &at_us) != LAM_OK) {
    fail(session, LAM_PART_OTHER, hal->error);
  } else if (hal->sense(hal->self, &senses) != LAM_OK) {
    fail(session, LAM_PART_ACTUATOR, hal->error);
  } else if (senses.estopped) {
    fail(session, LAM_PART_ESTOP, "the emergency stop is pressed: release it, then abort");
  } else if (senses.hottest_c > hottest_board_c(session->rig)) {
    fail(session, LAM_PART_HEAT, "the LEDs' board is too hot: let it cool, then abort");
  } else if (store_fault(session->store)[0] != '\0') {
    fail(session, LAM_PART_DISK, store_fault(session->store));
  }
}

// The frame's own message: what it is of, and when it really happened.
static void describe(const struct session* session, size_t step, unsigned camera,
                     lamella_v1_Frame* frame) {
  const struct burst_step* what = &session->plan.steps[step];
  const struct player* player = &session->player;
  const double delay_us = session->rig->camera_start_delay_us;
  const bool leds = burst_step_is_lit_by_leds(what);
  *frame = (lamella_v1_Frame)lamella_v1_Frame_init_zero;
  frame->has_step = frame->has_role = frame->has_index = frame->has_analyser = true;
  frame->step = (uint32_t)step;
  frame->role = what->role;
  frame->index = what->index;
  frame->analyser = what->crossed || camera == 1 ? lamella_v1_Frame_Analyser_CROSS
                                                 : lamella_v1_Frame_Analyser_PARALLEL;
  frame->has_camera = true;
  snprintf(frame->camera, sizeof frame->camera, "%s", camera == 0 ? "left" : "right");
  frame->trigger_us = player_actual_us(player, step, EDGE_TRIGGER, 1);
  const double untrigger_us = player_actual_us(player, step, EDGE_TRIGGER, 0);
  frame->exposure_us = untrigger_us - frame->trigger_us;
  frame->has_light_on_us = frame->has_light_off_us = true;
  frame->light_on_us =
      leds ? player_actual_us(player, step, EDGE_BLANK, 0) : frame->trigger_us + delay_us;
  frame->light_off_us =
      leds ? player_actual_us(player, step, EDGE_BLANK, 1) : untrigger_us + delay_us;
}

static void describe_raw(const lamella_v1_PhotographHeader* header, lamella_v1_Frame* frame) {
  frame->has_pixel_format = frame->has_black_level_dn = frame->has_gain_per_dn = true;
  memcpy(frame->pixel_format, header->pixel_format, sizeof frame->pixel_format);
  frame->black_level_dn = header->black_level_dn;
  frame->gain_per_dn = header->gain_per_dn;
  frame->radiance_scale_count = header->radiance_scale_count;
  memcpy(frame->radiance_scale, header->radiance_scale, sizeof frame->radiance_scale);
}

static bool collect(struct session* session) {
  const size_t step = session->collected / 2;
  const unsigned camera = session->collected % 2;
  struct hal* hal = session->hal;
  struct hal_photograph raw;
  raw.bytes = store_room(session->store, &raw.capacity);
  if (hal->read_photograph(hal->self, (unsigned)step, camera, &raw) != LAM_OK) {
    return fail(session, LAM_PART_CAMERA, raw.error);
  }
  struct photograph photograph = {.frame_id = session->collected,
                                  .width = raw.header.width,
                                  .height = raw.header.height,
                                  .size = raw.header.size_bytes,
                                  .crc32c = raw.header.crc32c,
                                  .marked = player_step_is_marked(&session->player, step)};
  describe(session, step, camera, &photograph.frame);
  describe_raw(&raw.header, &photograph.frame);
  if (!store_keep(session->store, &photograph)) {
    return fail(session, LAM_PART_DISK, store_fault(session->store));
  }
  session->collected++;
  session->has_progress = true;
  return true;
}

static void write_verdict(struct session* session) {
  lamella_v1_BurstDone* done = &session->done;
  const struct player* player = &session->player;
  *done = (lamella_v1_BurstDone){.burst_id = session->burst_id,
                                 .frame_count = session->collected,
                                 .marked = player->late_count > 0,
                                 .late_edges = (uint32_t)player->late_count};
  if (!done->marked) {
    snprintf(done->verdict, sizeof done->verdict, "%zu steps, %zu edges, none late",
             session->plan.count, session->timeline.count);
    return;
  }
  const struct edge* edge = &session->timeline.edges[player->first_late];
  snprintf(done->verdict, sizeof done->verdict,
           "MARKED: %zu of %zu edges late, the first %s of step %u by %.0f us", player->late_count,
           session->timeline.count, timeline_line_name(edge->line), edge->step,
           player->played[player->first_late].actual_us - edge->t_us);
}

static bool finish(struct session* session) {
  if (!store_is_written(session->store, kDiskWaitMs)) {
    session->has_progress = true;
    return true;
  }
  write_verdict(session);
  if (end_in_store(session, NULL) != LAM_OK)
    return fail(session, LAM_PART_DISK, store_fault(session->store));
  fprintf(stderr, "lamella-rigd: burst %llu: %s\n", (unsigned long long)session->burst_id,
          session->done.verdict);
  session->has_news = true;
  return go(session, STATE(IDLE)) == LAM_OK;
}

bool session_work(struct session* session) {
  if (session->state == STATE(ARMED)) return start(session);
  if (session->state != STATE(RUNNING)) return false;
  if (store_fault(session->store)[0] != '\0') {
    return fail(session, LAM_PART_DISK, store_fault(session->store));
  }
  if (session->playing) return play(session);
  if (session->collected < 2 * session->plan.count) return collect(session);
  return finish(session);
}

double session_slack_us(const struct session* session) {
  return session->playing ? player_slack_us(&session->player) : INFINITY;
}

enum lam_status session_abort(struct session* session) {
  session->hal->lights_off(session->hal->self);
  if (session->state == STATE(IDLE)) {
    return refuse(session, LAM_WRONG_STATE, "there is no burst to abort");
  }
  if (session->state != STATE(FAULT)) end_in_store(session, "aborted by the operator");
  session->playing = false;
  session->has_news = session->has_progress = false;
  session->fault[0] = '\0';
  return go(session, STATE(IDLE));
}

void session_status(const struct session* session, lamella_v1_Status* status) {
  *status = (lamella_v1_Status){.state = session->state,
                                .burst_id = session->burst_id,
                                .frames_held = (uint32_t)store_held(session->store),
                                .bursts_held = store_bursts_held(session->store)};
  snprintf(status->fault, sizeof status->fault, "%s", session->fault);
}
