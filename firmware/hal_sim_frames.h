// Photographs of nothing, of the size and format that a rig file's cameras have: what a burst costs
// a computer in packing, sums, memory and disk shows without a twin, which would cost far more.
#ifndef LAMELLA_FIRMWARE_HAL_SIM_FRAMES_H
#define LAMELLA_FIRMWARE_HAL_SIM_FRAMES_H

#include "hal.h"
#include "rig.h"

struct sim_frames {
  uint8_t* rows;  // as the sensor would hand them over; NULL: there are no such frames
  size_t row_bytes;
};

// LAM_BAD_INPUT, with the reason in `error`, where the rig file says nothing of its cameras.
enum lam_status sim_frames_open(struct sim_frames* frames, const struct rig* rig, char error[160]);
void sim_frames_close(struct sim_frames* frames);

// Packed as a board's photographs are. The first bytes are `number`, so that no two are alike.
enum lam_status sim_frames_photograph(struct sim_frames* frames, const struct rig* rig,
                                      uint8_t number, struct hal_photograph* photograph);

#endif
