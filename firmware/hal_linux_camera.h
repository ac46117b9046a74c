// A camera of the board: the photograph of each shot, found among the frames that come by its time
// stamp. A frame that was dropped is told as such, by a gap in the camera's sequence, by a stamp
// that fits another shot, or by a time-out.
#ifndef LAMELLA_FIRMWARE_HAL_LINUX_CAMERA_H
#define LAMELLA_FIRMWARE_HAL_LINUX_CAMERA_H

#include "hal.h"
#include "rig.h"

// As played, CLOCK_MONOTONIC. Numbers rise; those of retakes go on.
struct linux_shot {
  unsigned number;
  double trigger_us, untrigger_us;
};

struct linux_camera {
  void* self;  // first argument of every call
  char error[160];
  double exposure_us;  // what an edge-triggered camera says that it was set to; 0: the trigger's
  enum lam_status (*arm)(void* self);
  // Waits for that shot's frame, within a time-out of its own. To be called in the order of the
  // shots, after the shot's second edge, by a thread that is not the sequencer's. LAM_DROPPED where
  // there is no frame, or none to be trusted, and the next may well come. The reason is in `error`
  // and in the photograph's.
  enum lam_status (*read)(void* self, const struct linux_shot* shot,
                          struct hal_photograph* photograph);
  void (*disarm)(void* self);
  void (*close)(void* self);
};

// camera 0 is rig->board.camera_left, 1 camera_right: "v4l2:/dev/video0" or "libcamera:ID". The
// camera's trigger mode is set or checked as linux.camera_trigger says. `camera` must not move
// while it is open. On LAM_HARDWARE and LAM_BAD_INPUT nothing is held and `error` says why.
enum lam_status linux_camera_open(struct linux_camera* camera, const struct rig* rig,
                                  unsigned index);

#endif
