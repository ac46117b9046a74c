// The rig file: every number of one rig, `key = value`, one a line, units in the keys.
#ifndef LAMELLA_FIRMWARE_RIG_H
#define LAMELLA_FIRMWARE_RIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "rig_camera.h"
#include "rig_linux.h"
#include "status.h"

enum { RIG_MAX_LEDS = 168, RIG_MAX_TEXT_BYTES = 65536, RIG_MOST_PROJECTOR_PX = 4096 };
enum { PATTERN_FRINGES = 4, PATTERN_STRIPES = 4 };  // of a burst

struct led_place {
  uint8_t chip;         // 0 is nearest to the board
  uint8_t output;       // 0 to 23
  double direction[3];  // unit, rig frame, from the subject towards the LED
};

// Times in microseconds, named as in the file (firmware/board/sim.rig says what each means).
struct rig {
  double leds_spi_hz, leds_gsclk_hz, leds_light_us, leds_latch_us;
  double leds_longest_on_us, leds_duty_window_us, leds_highest_duty;
  double leds_power_w, leds_thermal_k_per_w, leds_thermal_time_us;
  double leds_ambient_c, leds_highest_junction_c;
  double camera_start_delay_us, camera_guard_us, camera_readout_us;
  double camera_frame_bytes, camera_f_number, camera_iso, camera_analyser_transmission;
  double analyser_move_us, analyser_settle_us;
  double projector_refresh_hz, projector_light_periods, projector_latency_us;
  double projector_settle_us, projector_commit_lead_us, projector_lamp_settle_us;
  double projector_width_px, projector_height_px, projector_gamma;
  double pattern_fringe_periods[PATTERN_FRINGES];
  double pattern_stripe_period_px, pattern_stripe_shift_px;
  double pattern_dot_pitch_px, pattern_dot_diameter_px;
  double pattern_dot_offset_u_px, pattern_dot_offset_v_px;
  double player_critical_tolerance_us, player_tolerance_us;
  double burst_pair_weight, burst_longest_us;
  double store_capacity_bytes, store_disk_bytes_per_s;
  double light_leds_lux, light_projector_lux, light_least_share;
  bool analyser_parks_crossed;
  bool camera_readout_overlaps;  // a sensor may integrate while the last frame is read out
  struct rig_linux board;
  struct rig_camera sensor;  // of each camera; only of a board that has cameras
  size_t led_count;
  struct led_place leds[RIG_MAX_LEDS];
};

struct rig_error {
  int line;  // from 1; 0 where no line is to blame (a missing key)
  char text[160];
};

// Reads a rig file's text. On LAM_BAD_INPUT `error` says which line, which key and what to do.
enum lam_status rig_parse(const char* text, size_t length, struct rig* rig,
                          struct rig_error* error);

double rig_pwm_period_us(const struct rig* rig);       // 4096 greyscale clocks
double rig_refresh_us(const struct rig* rig);          // of the projector
double rig_projector_light_us(const struct rig* rig);  // whole refresh periods
double rig_shift_us(const struct rig* rig);            // all bits of the driver chain over SPI

#endif
