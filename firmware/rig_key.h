// The table of a rig file's keys: what each may be and where it goes. Made of rig_keys.def and
// rig_linux_keys.def.
#ifndef LAMELLA_FIRMWARE_RIG_KEY_H
#define LAMELLA_FIRMWARE_RIG_KEY_H

#include "rig.h"
#include "rig_text.h"

enum { RIG_MAX_KEYS = 128 };

// The line that each key was given on, 0 where it was not.
struct rig_given {
  int lines[RIG_MAX_KEYS];
};

// Gives the optional keys what they are where a file has none of them.
void rig_key_presume(struct rig* rig);

// Takes one pair, or complains: an unknown key, one given twice, a value that it cannot have.
void rig_key_take(struct rig* rig, struct rig_given* given, const struct rig_pair* pair,
                  struct rig_errors* errors);

// The line that a key was given on; 0 where it was not.
int rig_key_line(const struct rig_given* given, const char* name);

void rig_key_require_all(const struct rig* rig, const struct rig_given* given,
                         struct rig_errors* errors);

#endif
