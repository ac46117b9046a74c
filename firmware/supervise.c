#define _GNU_SOURCE
#include "supervise.h"

#include <errno.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/pidfd.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

static const int kDarkWithinMs = 8;

static sigset_t handed_on(void) {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  return set;
}

// The parent may have died before the child could ask to be told.
static bool follow_parent(pid_t parent) {
  return prctl(PR_SET_PDEATHSIG, SIGTERM) == 0 && getppid() == parent;
}

// A busy board must not keep it from its only task. Without the right to it, it does it still.
static void claim_time(int priority) {
  const struct sched_param param = {.sched_priority = priority};
  if (priority > 0) sched_setscheduler(0, SCHED_FIFO, &param);
  mlockall(MCL_CURRENT);
}

// Until the child has ended; its state is still to be collected then.
static void watch(const struct supervised* supervised, pid_t child, int child_fd, int signal_fd) {
  struct pollfd ends[2] = {{.fd = child_fd, .events = POLLIN}, {.fd = signal_fd, .events = POLLIN}};
  int longest_ms = -1;
  while (ends[0].revents == 0) {
    const int ready = poll(ends, 2, longest_ms);
    if (ready < 0 && errno != EINTR) return;
    if (ready == 0 && supervised->is_lit(supervised->context)) kill(child, SIGKILL);
    if (ready == 0) longest_ms = -1;
    struct signalfd_siginfo received;
    if (ready <= 0 || ends[1].revents == 0) continue;
    if (read(signal_fd, &received, sizeof received) != sizeof received) continue;
    kill(child, SIGTERM);
    longest_ms = kDarkWithinMs;
  }
}

static int explain(pid_t child, int died_exit) {
  int status = 0;
  if (waitpid(child, &status, 0) != child) return died_exit;
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  fprintf(stderr, "lamella-rigd: the sequencer died (%s); its supervisor turned the lights off\n",
          strsignal(WTERMSIG(status)));
  return died_exit;
}

static void supervise(const struct supervised* supervised, pid_t child, int died_exit) {
  const sigset_t set = handed_on();
  const int child_fd = pidfd_open(child, 0);
  const int signal_fd = signalfd(-1, &set, SFD_CLOEXEC);
  if (child_fd < 0 || signal_fd < 0) {
    perror("lamella-rigd: supervisor");
    kill(child, SIGTERM);
  } else {
    claim_time(supervised->priority);
    watch(supervised, child, child_fd, signal_fd);
  }
  supervised->lights_off(supervised->context);
  _exit(explain(child, died_exit));
}

int supervise_fork(const struct supervised* supervised, int died_exit) {
  const sigset_t set = handed_on();
  const pid_t parent = getpid();
  sigprocmask(SIG_BLOCK, &set, NULL);
  fflush(NULL);
  const pid_t child = fork();
  if (child < 0) return -1;
  if (child > 0) supervise(supervised, child, died_exit);
  return follow_parent(parent) ? 0 : -1;
}
