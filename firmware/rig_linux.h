// The rig file's `linux.` keys: which of the kernel's devices the rig is wired to. Only a real
// board needs them. A text is empty where the file leaves an optional key out.
#ifndef LAMELLA_FIRMWARE_RIG_LINUX_H
#define LAMELLA_FIRMWARE_RIG_LINUX_H

#include <stdbool.h>

#include "rig_text.h"

struct rig_linux {
  bool given;  // the file has a `linux.` key
#define NUMBER(name, lowest, highest) double name;
#define WHOLE(name, lowest, highest) double name;
#define TEXT(name, required) char name[RIG_TEXT_CHARS];
#define LINE(name, required) char name[RIG_TEXT_CHARS];
#include "rig_linux_keys.def"
#undef NUMBER
#undef WHOLE
#undef TEXT
#undef LINE
};

#endif
