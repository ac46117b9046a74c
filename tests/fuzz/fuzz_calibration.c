// Any bytes as a rig's calibration: taken, or refused with a reason of one line. What is taken for
// cameras of one size is refused for those of another.
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "calibration.h"

static int is_taken(const char* text, size_t size, const struct rig_camera* own) {
  char why[CALIBRATION_WHY_CHARS] = "";
  const int taken = calibration_check(text, size, own, why);
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
