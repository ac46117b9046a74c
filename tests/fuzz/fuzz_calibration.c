// Any bytes as a rig's calibration: taken, or refused with a reason of one line. What is taken for
// cameras of one size is refused for those of another.
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "calibration.h"

static const struct rig kRig = {.projector_width_px = 1280,
                                .projector_height_px = 800,
                                .pattern_stripe_period_px = 8,
                                .pattern_stripe_shift_px = 2,
                                .pattern_dot_pitch_px = 53.33,
                                .pattern_dot_diameter_px = 20,
                                .pattern_dot_offset_u_px = 640,
                                .pattern_dot_offset_v_px = 400,
                                .pattern_fringe_periods = {1, 4, 16, 64},
                                .led_count = 1,
                                .leds = {{.direction = {0, 1, 0}}}};

static int is_taken(const char* text, size_t size, const struct rig_camera* own) {
  char why[CALIBRATION_WHY_CHARS] = "";
  const int taken = calibration_check(text, size, &kRig, own, why);
  if (taken != (why[0] == '\0') || strpbrk(why, "\r\n") != NULL) abort();
  return taken;
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  const struct rig_camera one = {.width_px = 160, .height_px = 120}, other = {.width_px = 161};
  const char* text = (const char*)bytes;
  const int any = is_taken(text, size, NULL), as_one = is_taken(text, size, &one);
  if (as_one && (!any || is_taken(text, size, &other))) abort();
  return 0;
}
