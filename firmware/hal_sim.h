// A rig in memory: time moves only when one waits (or passes for real), light comes from bits.
#ifndef LAMELLA_FIRMWARE_HAL_SIM_H
#define LAMELLA_FIRMWARE_HAL_SIM_H

#include <pthread.h>

#include "hal.h"
#include "hal_sim_faults.h"
#include "hal_sim_frames.h"
#include "hal_sim_light.h"

enum sim_clock { SIM_CLOCK_VIRTUAL, SIM_CLOCK_REAL };

enum { SIM_MAX_SIGNALS = 1024 };

// An edge of the operator's light or buzzer.
struct sim_signal {
  enum hal_line line;
  bool level;
  double at_us;
};

struct sim_shot {
  double open_us, close_us;
  bool missed;  // triggered, or over, during the readout of the one before
};

struct hal_sim {
  struct hal hal;
  const struct rig* rig;
  enum sim_clock clock;
  struct sim_faults faults;
  int twin_socket;
  struct sim_frames frames;  // in place of a twin's, where there are any
  double virtual_now_us;
  double opened_us;  // when the rig was switched on
  struct sim_light light;
  pthread_mutex_t light_lock;  // lights may go off while another thread reads a photograph
  struct sim_shot shots[SIM_MAX_EVENTS];
  size_t shot_count;  // another thread may read photographs of earlier shots
  bool triggered;
  bool playing;                                   // since the burst's zero, until lights off
  double zero_us;                                 // of the burst
  int pulse_count;                                // times that BLANK fell in this burst
  int shift_count;                                // LED frames sent in this burst
  struct hal_seen_edge seen[2 * SIM_MAX_EVENTS];  // BLANK and TRIGGER are looped back
  size_t seen_count, seen_given;
  double beat_us;         // the last edge of the heartbeat
  double last_vblank_us;  // some vblank: they come at whole refresh periods from it
  bool flip_pending, move_pending;
  double moved_us;                             // when the last move of the analyser was begun
  struct sim_signal signals[SIM_MAX_SIGNALS];  // the first ones since the rig was switched on
  size_t signal_count;
};

// The rig stands dark with its analyser parked. `twin_path` NULL: no photographs can be read.
enum lam_status hal_sim_open(struct hal_sim* sim, const struct rig* rig, enum sim_clock clock,
                             struct sim_faults faults, const char* twin_path);

// Photographs are made here from now on, not by a twin, and can be read while edges are played.
enum lam_status hal_sim_use_test_frames(struct hal_sim* sim);

#endif
