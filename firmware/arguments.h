// What lamella-rigd is asked for on its command line.
#ifndef LAMELLA_FIRMWARE_ARGUMENTS_H
#define LAMELLA_FIRMWARE_ARGUMENTS_H

#include <stdbool.h>

#include "hal_sim.h"

struct arguments {
  const char *hal, *rig, *twin, *calibration, *listen;
  const char *state, *name;   // of the link: see link_place
  const char* announce;       // write this file for Avahi, and end
  const char* store;          // NULL: photographs are kept in memory alone
  const char* led_reference;  // NULL: a reference that is learned is not kept
  bool standalone;            // the button starts bursts
  bool test_frames;           // in place of a twin's photographs
  const char* clock_name;     // NULL: none is given
  enum sim_clock clock;
  struct sim_faults faults;
  unsigned fault_kinds;  // those given: a bit for each sim_faults_kind()
  bool check;            // read the rig file, say all that is wrong with it, and end
  bool plan;             // the same, and write the burst that it would play
  bool help, version;
};

extern const char kArgumentsHelp[];

// False where something is wrong with them, which is said on standard error. What they name is not
// looked at yet.
bool arguments_parse(int argc, char** argv, struct arguments* arguments);

#endif
