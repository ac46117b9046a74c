// The supervisor: a process that holds the lights' lines beside the sequencer, and turns the lights
// off when that dies, however it dies.
#ifndef LAMELLA_FIRMWARE_SUPERVISE_H
#define LAMELLA_FIRMWARE_SUPERVISE_H

// What is done with what a supervisor and its sequencer share.
struct supervised {
  void* context;
  void (*lights_off)(void* context);
  int priority;  // of SCHED_FIFO for the supervisor; 0: none
};

// Forks. In the child it returns 0: the sequencer, which gets SIGTERM when its supervisor dies. The
// parent never returns here: it hands SIGTERM and SIGINT on, waits for the child's end, turns the
// lights off and ends with the child's exit code, or with `died_exit` where a signal killed it.
// -1 where there can be no child.
int supervise_fork(const struct supervised* supervised, int died_exit);

#endif
