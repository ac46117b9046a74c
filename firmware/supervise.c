#define _GNU_SOURCE
#include "supervise.h"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <semaphore.h>
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

#include "complain.h"

static const int kDarkWithinMs = 8;

// A dying process gives its memory back, and closes its devices, before its pidfd tells of its end:
// more than the lights may stay on. A robust lock that it held is told of before that.
struct life {
  pthread_mutex_t lock;  // held by the sequencer until it ends
  sem_t is_held;
};

// Shared by a supervisor and its sequencer. NULL where it cannot be had.
static struct life* make_life(void) {
  struct life* life =
      mmap(NULL, sizeof *life, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (life == MAP_FAILED) return NULL;
  pthread_mutexattr_t shared;
  pthread_mutexattr_init(&shared);
  pthread_mutexattr_setpshared(&shared, PTHREAD_PROCESS_SHARED);
  pthread_mutexattr_setrobust(&shared, PTHREAD_MUTEX_ROBUST);
  const bool made =
      pthread_mutex_init(&life->lock, &shared) == 0 && sem_init(&life->is_held, 1, 0) == 0;
  pthread_mutexattr_destroy(&shared);
  return made ? life : NULL;
}

static bool live(struct life* life) {
  return pthread_mutex_lock(&life->lock) == 0 && sem_post(&life->is_held) == 0;
}

struct mourner {
  const struct supervised* supervised;
  struct life* life;
  pthread_mutex_t one_at_a_time;
  bool darkened;
};

static void darken(struct mourner* mourner) {
  pthread_mutex_lock(&mourner->one_at_a_time);
  if (!mourner->darkened) mourner->supervised->lights_off(mourner->supervised->context);
  mourner->darkened = true;
  pthread_mutex_unlock(&mourner->one_at_a_time);
}

static bool is_lit(struct mourner* mourner) {
  pthread_mutex_lock(&mourner->one_at_a_time);
  const bool lit = !mourner->darkened && mourner->supervised->is_lit(mourner->supervised->context);
  pthread_mutex_unlock(&mourner->one_at_a_time);
  return lit;
}

static void* mourn(void* context) {
  struct mourner* mourner = context;
  while (sem_wait(&mourner->life->is_held) != 0) continue;
  pthread_mutex_lock(&mourner->life->lock);
  darken(mourner);
  return NULL;
}

static bool is_ignored(int number) {
  struct sigaction action;
  return sigaction(number, NULL, &action) == 0 && action.sa_handler == SIG_IGN;
}

static sigset_t handed_on(void) {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  if (!is_ignored(SIGHUP)) sigaddset(&set, SIGHUP);  // a terminal was closed; nohup stays nohup
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
static void watch(struct mourner* mourner, pid_t child, int child_fd, int signal_fd) {
  struct pollfd ends[2] = {{.fd = child_fd, .events = POLLIN}, {.fd = signal_fd, .events = POLLIN}};
  int longest_ms = -1;
  while (ends[0].revents == 0) {
    const int ready = poll(ends, 2, longest_ms);
    if (ready < 0 && errno != EINTR) return;
    if (ready == 0 && is_lit(mourner)) kill(child, SIGKILL);
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
  complain("lamella-rigd: the sequencer died (%s); its supervisor turned the lights off",
           strsignal(WTERMSIG(status)));
  return died_exit;
}

static void supervise(struct mourner* mourner, pid_t child, int died_exit) {
  const sigset_t set = handed_on();
  const int child_fd = pidfd_open(child, 0);
  const int signal_fd = signalfd(-1, &set, SFD_CLOEXEC);
  if (child_fd < 0 || signal_fd < 0) {
    perror("lamella-rigd: supervisor");
    kill(child, SIGTERM);
  } else {
    pthread_t thread;
    claim_time(mourner->supervised->priority);
    // Without the thread the child's end is told a little later. Nobody waits for it: where the
    // child died before it held the lock, it does not end.
    if (pthread_create(&thread, NULL, mourn, mourner) == 0) {
      pthread_detach(thread);
    } else {
      perror("lamella-rigd: supervisor");
    }
    watch(mourner, child, child_fd, signal_fd);
  }
  darken(mourner);
  _exit(explain(child, died_exit));
}

int supervise_fork(const struct supervised* supervised, int died_exit) {
  const sigset_t set = handed_on();
  const pid_t parent = getpid();
  sigprocmask(SIG_BLOCK, &set, NULL);
  fflush(NULL);
  struct mourner mourner = {
      .supervised = supervised, .life = make_life(), .one_at_a_time = PTHREAD_MUTEX_INITIALIZER};
  const pid_t child = mourner.life != NULL ? fork() : -1;
  if (child < 0) return -1;
  if (child > 0) supervise(&mourner, child, died_exit);
  return live(mourner.life) && follow_parent(parent) ? 0 : -1;
}
