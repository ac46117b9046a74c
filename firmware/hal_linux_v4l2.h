// Frames through Video4Linux: a capture device, memory-mapped buffers, controls by name.
#ifndef LAMELLA_FIRMWARE_HAL_LINUX_V4L2_H
#define LAMELLA_FIRMWARE_HAL_LINUX_V4L2_H

#include "hal_linux_frames.h"

// Opens the device, sets format and size, the trigger mode and, where one is wished, the exposure,
// which the camera is then asked for. On failure nothing is held.
linux_frames_opener linux_v4l2_open;

#endif
