// The supervisor: a process that holds the lights' lines beside the sequencer, and turns the lights
// off when that dies, however it dies.
#ifndef LAMELLA_FIRMWARE_SUPERVISE_H
#define LAMELLA_FIRMWARE_SUPERVISE_H

#include <stdbool.h>

// What is done with what a supervisor and its sequencer share.
struct supervised {
  void* context;
  void (*lights_off)(void* context);
  bool (*is_lit)(void* context);  // as the lines themselves say
  int priority;                   // of SCHED_FIFO for the supervisor; 0: none
};

// Forks. In the child it returns 0: the sequencer, which gets SIGTERM when its supervisor dies. The
// parent never returns here: it hands SIGTERM and SIGINT on, waits for the child's end, turns the
// lights off and ends with the child's exit code, or with `died_exit` where a signal killed it. A
// child that leaves a light on for 8 ms after it was told to end is killed.
// -1 where there can be no child.
int supervise_fork(const struct supervised* supervised, int died_exit);

#endif
