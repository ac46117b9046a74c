#define _GNU_SOURCE
#include "hal_linux_time.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "complain.h"

enum { kTicksSeen = 4 };
static const double kShortestTickUs = 100;  // a coarse clock that is finer is set by no tick

double linux_now_us(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec * 1e6 + (double)now.tv_nsec * 1e-3;
}

double linux_wait_until_us(double t_us, double spin_us) {
  const double wake_us = t_us - spin_us;
  if (wake_us > linux_now_us()) {
    const struct timespec wake = {.tv_sec = (time_t)(wake_us / 1e6),
                                  .tv_nsec = (long)(fmod(wake_us, 1e6) * 1e3)};
    // A signal ends the sleep early; the spin below still keeps the time.
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, NULL);
  }
  double now_us;
  do now_us = linux_now_us();
  while (now_us < t_us);
  return now_us;
}

static int report(bool had, const char* setting) {
  if (had) return 0;
  complain("lamella-rigd: timing: %s cannot be had: %s", setting, strerror(errno));
  return 1;
}

static bool pin(int cpu) {
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  CPU_SET(cpu, &cpus);
  return sched_setaffinity(0, sizeof cpus, &cpus) == 0;
}

// The kernel honours the 0 us for as long as the file is open.
static int forbid_deep_sleep(void) {
  const int fd = open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC);
  const int32_t latency_us = 0;
  if (fd < 0 || write(fd, &latency_us, sizeof latency_us) == sizeof latency_us) return fd;
  const int reason = errno;
  close(fd);
  errno = reason;
  return -1;
}

int linux_time_settle(const struct rig_linux* board, int* latency_fd) {
  char setting[64];
  snprintf(setting, sizeof setting, "processor %d (linux.cpu)", (int)board->cpu);
  int missing = report(pin((int)board->cpu), setting);
  const struct sched_param param = {.sched_priority = (int)board->priority};
  missing += report(sched_setscheduler(0, SCHED_FIFO, &param) == 0, "SCHED_FIFO (linux.priority)");
  *latency_fd = forbid_deep_sleep();
  return missing + report(*latency_fd >= 0, "/dev/cpu_dma_latency");
}

static double coarse_now_us(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC_COARSE, &now);
  return (double)now.tv_sec * 1e6 + (double)now.tv_nsec * 1e-3;
}

// Spins until the kernel's next tick; false where none comes. The coarse clock moves with each tick
// and stands still between them.
static bool await_tick(double tick_us, double* at_us) {
  const double from_us = linux_now_us(), stood_us = coarse_now_us();
  do *at_us = linux_now_us();
  while (coarse_now_us() == stood_us && *at_us < from_us + 3 * tick_us);
  return coarse_now_us() != stood_us;
}

double linux_tick_us(double* at_us) {
  struct timespec every;
  if (clock_getres(CLOCK_MONOTONIC_COARSE, &every) != 0) return 0;
  const double tick_us = (double)every.tv_sec * 1e6 + (double)every.tv_nsec * 1e-3;
  if (tick_us < kShortestTickUs || !await_tick(tick_us, at_us)) return 0;
  // What is seen late is late by what came between: the earliest is the tick's own.
  for (int i = 0; i < kTicksSeen; i++) {
    double next_us = 0;
    if (!await_tick(tick_us, &next_us)) return 0;
    const double off_us = remainder(next_us - *at_us, tick_us);
    if (off_us < 0) *at_us += off_us;
  }
  return tick_us;
}

enum lam_status linux_memory_lock(char error[160]) {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return LAM_OK;
  const int reason = errno;
  struct rlimit limit = {.rlim_cur = 0};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  snprintf(error, 160,
           "too little memory may be locked: %s; the limit is %llu KiB: set LimitMEMLOCK=infinity "
           "in the unit, or ulimit -l unlimited",
           strerror(reason), (unsigned long long)limit.rlim_cur / 1024);
  return LAM_HARDWARE;
}
