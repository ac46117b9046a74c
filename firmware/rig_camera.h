// The rig file's keys for what a real camera sends, `camera.` as the planner's. All of them that
// are required must be there where `linux.camera_left` is; a simulated rig has none.
//
//   camera.width_px, camera.height_px
//   camera.format           as V4L2 says it, without V4L2_PIX_FMT_: "Y10P", "SRGGB12"
//                           (raw_pixels.h)
//   camera.sensor           imx296, ov9281 or other; of the first two the other keys are checked
//                           (rig_sensor.h)
//   camera.black_level_dn   value of no light, in 12-bit steps of the stored photograph
//   camera.full_scale_dn    value at and above which a pixel is clipped; becomes 1.0
//   camera.trigger          level: it integrates while the line is active. edge: from the trigger's
//                           edge on for the time that the camera is told
//   camera.trigger_active   high: the line is 1 while the cameras are triggered, else 0; low: the
//                           other way round. The line as the board drives it: what is behind it,
//                           an inverting level shifter, does not count
//   camera.exposure_step_us edge alone, V4L2 alone: the unit of the camera's control "Exposure"
//   camera.stamp            the instant that a frame's time stamp is of: opened, closed, read_out
//   camera.stamp_late_us    the stamp may come this much after that instant
#ifndef LAMELLA_FIRMWARE_RIG_CAMERA_H
#define LAMELLA_FIRMWARE_RIG_CAMERA_H

#include <stdbool.h>

#include "raw_pixels.h"

enum { RIG_CAMERA_KEYS = 11 };

enum rig_sensor_name { RIG_SENSOR_OTHER, RIG_SENSOR_IMX296, RIG_SENSOR_OV9281 };
enum rig_stamp { RIG_STAMP_OPENED, RIG_STAMP_CLOSED, RIG_STAMP_READ_OUT };

struct rig_camera {
  double width_px, height_px;
  const struct raw_format* format;
  enum rig_sensor_name name;
  double black_level_dn, full_scale_dn;
  bool edge_triggered;
  bool trigger_active_low;
  double exposure_step_us;
  enum rig_stamp stamp;
  double stamp_late_us;
  bool seen[RIG_CAMERA_KEYS];
};

bool rig_camera_knows(const char* key);

// Takes one key that rig_camera_knows(). False, with a reason in `error`, where it is wrong.
bool rig_camera_take(struct rig_camera* camera, const char* key, const char* value,
                     char error[160]);

// Whether all is there that a camera on a board needs; else `error` says what is missing or does
// not fit together.
bool rig_camera_complete(const struct rig_camera* camera, char error[160]);

#endif
