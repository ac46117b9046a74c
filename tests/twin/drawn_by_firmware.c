#include "drawn_by_firmware.h"

#include "pattern.h"

double drawn_by_firmware(const char* rig_file, size_t length, const int pattern[2],
                         const size_t size[2], uint32_t* pixels) {
  static struct rig rig;
  static struct rig_errors errors;
  if (rig_parse(rig_file, length, &rig, &errors) != LAM_OK) return 0;
  const size_t image = pattern_image(
      (struct hal_pattern){(lamella_v1_PatternSpan_Kind)pattern[0], (uint8_t)pattern[1]});
  const bool fits = rig.projector_width_px == (double)size[0] &&
                    rig.projector_height_px == (double)size[1] && image < PATTERN_IMAGES;
  if (!fits) return 0;
  pattern_draw(&rig, image, pixels, size[0]);
  return rig.projector_gamma;
}
