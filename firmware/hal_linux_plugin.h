// Opens a libcamera camera through the plug-in LINUX_FRAMES_PLUGIN, which is looked for in
// LAMELLA_PLUGIN_DIR alone.
#ifndef LAMELLA_FIRMWARE_HAL_LINUX_PLUGIN_H
#define LAMELLA_FIRMWARE_HAL_LINUX_PLUGIN_H

#include "hal_linux_frames.h"

// Loads the plug-in, once a process: it stays loaded, as libcamera's threads outlive a camera.
linux_frames_opener linux_plugin_open;

#endif
