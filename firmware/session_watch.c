#include "session_inside.h"

#define STATE(name) lamella_v1_RigState_##name

static const double kHostSilentUs = 500e3;

void session_tie_to_host(struct session* session) {
  session->ends_with_host = true;
  session_hear_host(session);
}

void session_hear_host(struct session* session) {
  session->host_heard_us = session->hal->now_us(session->hal->self);
}

void session_lose_host(struct session* session) {
  const bool under_way = session->state == STATE(ARMED) || session->playing;
  if (!session->ends_with_host || !under_way) return;
  session_fail(session, LAM_PART_OTHER, "the host that the burst is tied to is gone");
}

static bool is_host_silent(const struct session* session) {
  const double silent_us = session->hal->now_us(session->hal->self) - session->host_heard_us;
  return session->ends_with_host && silent_us > kHostSilentUs;
}

void session_watch(struct session* session) {
  if (!session->playing) return;
  struct hal* hal = session->hal;
  struct hal_senses senses;
  if (hal_beat(hal) != LAM_OK) {
    session_fail(session, LAM_PART_OTHER, hal->error);
  } else if (hal->sense(hal->self, &senses) != LAM_OK) {
    session_fail(session, LAM_PART_OTHER, hal->error);
  } else if (senses.stuck) {
    session_fail(session, LAM_PART_ACTUATOR, HAL_STUCK);
  } else if (senses.estopped) {
    session_fail(session, LAM_PART_ESTOP, "the emergency stop is pressed: release it, then abort");
  } else if (senses.hottest_c > rig_hottest_board_c(session->rig)) {
    session_fail(session, LAM_PART_HEAT, "the LEDs' board is too hot: let it cool, then abort");
  } else if (store_fault(session->store)[0] != '\0') {
    session_fail(session, LAM_PART_DISK, store_fault(session->store));
  } else if (collector_has_failed(&session->collector)) {
    session_fail_by_collector(session);
  } else if (is_host_silent(session)) {
    session_lose_host(session);
  } else {
    player_hear_loopbacks(&roll_newest_take(&session->roll)->player);
  }
}
