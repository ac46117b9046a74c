#include "standalone.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "complain.h"
#include "supervise_notify.h"

static const double kTickUs = 10e3;  // the button is felt this often
static const double kVerdictUs = 5e6;
static const char kTesting[] = "the rig tests itself";
static const char kCountingDown[] = "the rig's button was pressed: it counts down";

static double now_us(const struct standalone* alone) {
  return alone->hal->now_us(alone->hal->self);
}

static void go(struct standalone* alone, enum standalone_state state, enum panel_code code) {
  alone->state = state;
  alone->since_us = now_us(alone);
  panel_show(&alone->panel, code, alone->since_us);
  alone->session->occupied = state == STANDALONE_TESTING     ? kTesting
                             : state == STANDALONE_COUNTDOWN ? kCountingDown
                                                             : NULL;
  notify_status(kPanelTable[code].name);
}

static enum panel_code fault_code(enum lam_part part) {
  static const enum panel_code kCodes[] = {
      [LAM_PART_OTHER] = PANEL_FAULT_OTHER,       [LAM_PART_ESTOP] = PANEL_FAULT_ESTOP,
      [LAM_PART_HEAT] = PANEL_FAULT_HOT,          [LAM_PART_CAMERA] = PANEL_FAULT_CAMERA,
      [LAM_PART_ACTUATOR] = PANEL_FAULT_ACTUATOR, [LAM_PART_LED_CHAIN] = PANEL_FAULT_LED_CHAIN,
      [LAM_PART_DISK] = PANEL_FAULT_DISK,         [LAM_PART_PROJECTOR] = PANEL_FAULT_PROJECTOR,
  };
  return kCodes[part];
}

static void begin_test(struct standalone* alone, unsigned parts, bool quick, bool learning) {
  alone->selftest->stands_crossed = alone->session->stands_crossed;
  selftest_begin(alone->selftest, parts, quick, learning);
  notify_testing(true);
  go(alone, STANDALONE_TESTING, PANEL_STARTING);
}

void standalone_init(struct standalone* alone, struct session* session, struct selftest* selftest,
                     unsigned parts) {
  memset(alone, 0, sizeof *alone);
  alone->rig = session->rig;
  alone->hal = session->hal;
  alone->session = session;
  alone->selftest = selftest;
  alone->parts = parts;
  panel_init(&alone->panel, now_us(alone));
  begin_test(alone, parts, true, false);
}

static void report_test(const struct selftest* test) {
  for (size_t i = 0; i < test->count; i++) {
    char text[SELFTEST_WHY_CHARS];
    const struct selftest_reading* r = &test->readings[i];
    if (r->verdict != SELFTEST_BAD) continue;
    selftest_tell(r, text);
    complain("lamella-rigd: self-test: %s: %s", selftest_part_name(r->part), text);
  }
}

// Where nothing is under way: ready, or at fault as a burst or self-tests left it.
static enum panel_code resting_code(const struct standalone* alone) {
  const struct session* session = alone->session;
  if (session->state == lamella_v1_RigState_FAULT) return fault_code(session->fault_part);
  if (alone->selftest->unfit == 0) return PANEL_READY;
  return fault_code(selftest_failed_part(alone->selftest));
}

static void rest(struct standalone* alone) {
  const enum panel_code code = resting_code(alone);
  go(alone, code == PANEL_READY ? STANDALONE_READY : STANDALONE_FAULT, code);
}

static void test(struct standalone* alone) {
  struct selftest* selftest = alone->selftest;
  if (selftest_work(selftest)) return;
  notify_testing(false);
  alone->session->stands_crossed = selftest->stands_crossed;
  // Where the wire that darkens all lights is bad nobody gets a burst.
  snprintf(alone->session->unfit, sizeof alone->session->unfit, "%.127s",
           selftest->why[SELFTEST_BLANK]);
  report_test(selftest);
  rest(alone);
}

// Found outside a self-test: unfit until one finds it good, or the button has it tested.
static void condemn(struct standalone* alone, enum lam_part part) {
  if (part == LAM_PART_ESTOP) {
    selftest_condemn(alone->selftest, SELFTEST_ESTOP,
                     "pressed: release it, then press START, which tests it");
  } else if (part == LAM_PART_HEAT) {
    selftest_condemn(alone->selftest, SELFTEST_TEMPERATURE,
                     "too hot: let the LEDs cool, then press START, which tests them");
  }
}

// What the inputs forbid before anything is asked of the rig.
static void watch(struct standalone* alone, const struct hal_senses* senses) {
  const bool hot = senses->hottest_c > rig_hottest_board_c(alone->rig);
  if (!senses->estopped && !hot) return;
  condemn(alone, senses->estopped ? LAM_PART_ESTOP : LAM_PART_HEAT);
  rest(alone);
}

// Fault cleared, and the rig tested again before it says that it is ready.
static void recover(struct standalone* alone) {
  if (alone->session->state == lamella_v1_RigState_FAULT) session_abort(alone->session);
  const struct selftest* test = alone->selftest;
  begin_test(alone, alone->parts | test->unfit, !test->needs_full, false);
}

static void click(struct standalone* alone) {
  const bool idle = alone->session->state == lamella_v1_RigState_IDLE;
  if (alone->state == STANDALONE_READY && !(alone->has_button && idle)) {
    go(alone, STANDALONE_VERDICT, PANEL_REFUSED_BUSY);
  } else if (alone->state == STANDALONE_READY) {
    go(alone, STANDALONE_COUNTDOWN, PANEL_COUNTDOWN);
  } else if (alone->state == STANDALONE_FAULT) {
    recover(alone);
  } else if (alone->state == STANDALONE_COUNTDOWN || alone->state == STANDALONE_VERDICT) {
    rest(alone);
  }
}

static void on_event(struct standalone* alone, enum panel_event event) {
  if (event == PANEL_CLICKED) click(alone);
  if (event == PANEL_HELD && alone->state != STANDALONE_BURST &&
      alone->state != STANDALONE_TESTING) {
    go(alone, STANDALONE_PAIRING, PANEL_PAIRING);
  }
  if (event == PANEL_RELEASED && alone->state == STANDALONE_PAIRING) rest(alone);
}

// A session that is idle and refuses for its state has no room: photographs are held. The only
// device that it asks is the disk.
static enum panel_code refused_code(enum lam_status status) {
  if (status == LAM_UNSAFE) return PANEL_REFUSED_UNSAFE;
  return status == LAM_HARDWARE ? PANEL_FAULT_DISK : PANEL_REFUSED_FULL;
}

static void begin_burst(struct standalone* alone) {
  alone->session->occupied = NULL;
  // Whoever presses the button sees the subject, and answers for it (README.md, Safety).
  alone->session->flashing_unconfirmed = false;
  const enum lam_status status = session_request_burst(alone->session, false);
  if (status == LAM_OK) {
    go(alone, STANDALONE_BURST, PANEL_BURST);
    return;
  }
  complain("lamella-rigd: button: refused: %s", alone->session->refusal);
  go(alone, STANDALONE_VERDICT, refused_code(status));
}

static void give_verdict(struct standalone* alone) {
  const struct session* session = alone->session;
  if (session->state == lamella_v1_RigState_FAULT) {
    condemn(alone, session->fault_part);
    rest(alone);
  } else if (session->done.burst_id != session->burst_id) {  // aborted by a host
    rest(alone);
  } else {
    const enum panel_code kept = session->done.retaken > 0 ? PANEL_RETAKEN : PANEL_GOOD;
    go(alone, STANDALONE_VERDICT, session->done.marked ? PANEL_MARKED : kept);
  }
}

// A burst, whoever asked for it, from its beginning to its verdict.
static void follow_session(struct standalone* alone) {
  const struct session* session = alone->session;
  if (!session_is_busy(session)) {
    if (alone->state == STANDALONE_BURST) give_verdict(alone);
    return;
  }
  const bool dark = session->playing || session->state == lamella_v1_RigState_ARMED;
  const enum panel_code code = dark ? PANEL_BURST : PANEL_STORING;
  if (alone->state != STANDALONE_BURST || alone->panel.code != code) {
    go(alone, STANDALONE_BURST, code);
  }
}

static void pass_time(struct standalone* alone) {
  const double in_state_us = now_us(alone) - alone->since_us;
  const double countdown_us = panel_pattern_length_us(&kPanelTable[PANEL_COUNTDOWN].buzzer);
  if (alone->state == STANDALONE_COUNTDOWN && in_state_us >= countdown_us) begin_burst(alone);
  if (alone->state == STANDALONE_VERDICT && in_state_us >= kVerdictUs) rest(alone);
  // A fault that somebody cleared over the link.
  if (alone->state == STANDALONE_FAULT && alone->panel.code != resting_code(alone)) rest(alone);
}

static void set(struct standalone* alone, enum hal_line line, bool level, bool* is) {
  double at_us = 0;
  if (level == *is) return;
  *is = level;
  if (alone->hal->set_line(alone->hal->self, line, level, &at_us) == LAM_OK) return;
  if (!alone->lines_failed) complain("lamella-rigd: panel: %s", alone->hal->error);
  alone->lines_failed = true;
}

static void show(struct standalone* alone) {
  const double t_us = now_us(alone);
  panel_tick(&alone->panel, t_us);
  bool code = false;
  const bool pairing = alone->code_light != NULL && alone->code_light(alone->code_context, &code);
  set(alone, HAL_READY, pairing ? code : alone->panel.light, &alone->ready_lit);
  set(alone, HAL_BUZZER, pairing ? code : alone->panel.buzzer, &alone->buzzing);
}

double standalone_tend(void* context) {
  struct standalone* alone = context;
  struct hal_senses senses;
  // Nothing but the burst itself while edges are played.
  if (!alone->session->playing && alone->hal->sense(alone->hal->self, &senses) == LAM_OK) {
    if (alone->state == STANDALONE_READY || alone->state == STANDALONE_COUNTDOWN) {
      watch(alone, &senses);
    }
    on_event(alone, panel_feel(&alone->panel, senses.start_pressed, now_us(alone)));
  }
  follow_session(alone);
  pass_time(alone);
  show(alone);
  if (alone->state == STANDALONE_TESTING) test(alone);
  notify_alive(now_us(alone));
  return now_us(alone) + (alone->state == STANDALONE_TESTING ? 0 : kTickUs);
}

enum lam_status standalone_request_selftest(struct standalone* alone, unsigned parts, bool learning,
                                            const char** why) {
  *why = alone->session->occupied != NULL ? alone->session->occupied : "a burst is under way";
  const bool idle = !session_is_busy(alone->session) && alone->session->occupied == NULL;
  if (!idle) return LAM_WRONG_STATE;
  begin_test(alone, parts, false, learning);
  return LAM_OK;
}

bool standalone_is_held(const struct standalone* alone) { return alone->panel.held; }
