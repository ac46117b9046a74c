// The rig file's linux.camera_trigger: how a camera is told to wait for triggers.
//
//   control:NAME=NUMBER   a V4L2 control is set, by its name, to a decimal number, and asked for
//   again module:imx296/parameters/trigger_mode=1   a kernel module's parameter must be that; only
//   a
//                         restart can change it
//   fixed                 the camera's own; nothing to do
#ifndef LAMELLA_FIRMWARE_RIG_HOOK_H
#define LAMELLA_FIRMWARE_RIG_HOOK_H

#include <stdbool.h>

#include "rig_text.h"

enum rig_hook_kind { RIG_HOOK_FIXED, RIG_HOOK_CONTROL, RIG_HOOK_MODULE };

struct rig_hook {
  enum rig_hook_kind kind;
  char name[RIG_TEXT_CHARS];   // of the control, or "imx296/parameters/trigger_mode"
  char value[RIG_TEXT_CHARS];  // as it stands there
  long number;                 // of a control
};

// False, with a reason in `error`, where the text is none of these.
bool rig_hook_read(const char* text, struct rig_hook* hook, char error[160]);

#endif
