// A camera's settings beside its stream: how it is triggered, and for how long it integrates.
#ifndef LAMELLA_FIRMWARE_HAL_LINUX_CONTROLS_H
#define LAMELLA_FIRMWARE_HAL_LINUX_CONTROLS_H

#include "status.h"

enum { LINUX_CONTROLS_ERROR_CHARS = 160 };

// Does to the camera behind `device` what `hook` says, the rig file's linux.camera_trigger
// (rig_hook.h).
enum lam_status linux_controls_trigger(const char* device, const char* hook,
                                       char error[LINUX_CONTROLS_ERROR_CHARS]);

// Sets V4L2_CID_EXPOSURE, counted in steps of step_us, or else V4L2_CID_EXPOSURE_ABSOLUTE, whose
// steps are 100 us, to the nearest to wished_us, and asks the camera what it is: `exposure_us`,
// which may differ from the wish by no more than a step.
enum lam_status linux_controls_expose(const char* device, double step_us, double wished_us,
                                      double* exposure_us, char error[LINUX_CONTROLS_ERROR_CHARS]);

#endif
