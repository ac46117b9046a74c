// A camera's settings beside its stream: how it is triggered, and for how long it integrates.
#ifndef LAMELLA_FIRMWARE_HAL_LINUX_CONTROLS_H
#define LAMELLA_FIRMWARE_HAL_LINUX_CONTROLS_H

#include "status.h"

enum { LINUX_CONTROLS_ERROR_CHARS = 160 };

// `hook` is the rig file's linux.camera_trigger:
//   control:NAME=VALUE   sets the V4L2 control of that name of `device`, and asks for it again
//   module:imx296/parameters/trigger_mode=1   the kernel module's parameter must be that; only a
//                        restart can change it, and `error` says which line does
//   fixed                the camera's own; nothing to do
enum lam_status linux_controls_trigger(const char* device, const char* hook,
                                       char error[LINUX_CONTROLS_ERROR_CHARS]);

// Sets V4L2_CID_EXPOSURE, counted in steps of step_us, to the nearest to wished_us, and asks the
// camera what it is: `exposure_us`, which may differ from the wish by no more than a step.
enum lam_status linux_controls_expose(const char* device, double step_us, double wished_us,
                                      double* exposure_us, char error[LINUX_CONTROLS_ERROR_CHARS]);

#endif
