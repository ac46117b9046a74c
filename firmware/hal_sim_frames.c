#include "hal_sim_frames.h"

#include <stdio.h>
#include <stdlib.h>

#include "crc32c.h"

static enum lam_status refuse(char error[160], const char* why) {
  snprintf(error, 160, "%s", why);
  return LAM_BAD_INPUT;
}

// Noise, so that no disk that packs or leaves out what repeats takes it for less than it is.
static void fill(uint8_t* bytes, size_t size) {
  uint32_t state = 1;
  for (size_t i = 0; i < size; i++) {
    state = state * 1664525 + 1013904223;
    bytes[i] = (uint8_t)(state >> 24);
  }
}

enum lam_status sim_frames_open(struct sim_frames* frames, const struct rig* rig, char error[160]) {
  const struct rig_camera* sensor = &rig->sensor;
  char why[160];
  *frames = (struct sim_frames){0};
  if (!rig_camera_complete(sensor, why)) {
    return refuse(error,
                  "--test-frames: this rig file does not say what its cameras send "
                  "(camera.width_px, camera.format): give a board's");
  }
  frames->row_bytes = raw_row_bytes(sensor->format, (size_t)sensor->width_px);
  const size_t size = frames->row_bytes * (size_t)sensor->height_px;
  frames->rows = malloc(size);
  if (frames->rows == NULL) return refuse(error, "--test-frames: no memory for one of that size");
  fill(frames->rows, size);
  return LAM_OK;
}

void sim_frames_close(struct sim_frames* frames) {
  free(frames->rows);
  *frames = (struct sim_frames){0};
}

enum lam_status sim_frames_photograph(struct sim_frames* frames, const struct rig* rig,
                                      uint8_t number, struct hal_photograph* photograph) {
  const struct rig_camera* sensor = &rig->sensor;
  const size_t size[2] = {(size_t)sensor->width_px, (size_t)sensor->height_px};
  if (raw_stored_bytes(size[0], size[1]) > photograph->capacity) {
    snprintf(photograph->error, sizeof photograph->error,
             "no room for a photograph: raise store.capacity_bytes");
    return LAM_HARDWARE;
  }
  frames->rows[0] = frames->rows[1] = number;
  const size_t bytes =
      raw_pack(sensor->format, frames->rows, frames->row_bytes, size, photograph->bytes);
  lamella_v1_PhotographHeader* header = &photograph->header;
  *header = (lamella_v1_PhotographHeader){
      .width = (uint32_t)size[0],
      .height = (uint32_t)size[1],
      .size_bytes = (uint32_t)bytes,
      .crc32c = crc32c_extend(0, photograph->bytes, bytes),
      .black_level_dn = sensor->black_level_dn,
      .gain_per_dn = 1 / (sensor->full_scale_dn - sensor->black_level_dn)};
  snprintf(header->pixel_format, sizeof header->pixel_format, "%s", sensor->format->stored);
  return LAM_OK;
}
