#define _GNU_SOURCE
#include "collector.h"

#include <errno.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "complain.h"

enum { kStackBytes = 256 * 1024, kCameras = 2 };
static const double kLongestStopUs = 1e6;

static void fail(struct collector* c, const char* why) {
  snprintf(c->error, sizeof c->error, "%s", why);
  __atomic_store_n(&c->failed, true, __ATOMIC_SEQ_CST);
}

static struct photograph describe(const struct collector* c, unsigned number,
                                  const lamella_v1_PhotographHeader* header) {
  struct photograph photograph = {.frame_id = number,
                                  .width = header->width,
                                  .height = header->height,
                                  .size = header->size_bytes,
                                  .crc32c = header->crc32c};
  lamella_v1_Frame* frame = &photograph.frame;
  roll_describe_frame(c->roll, number / kCameras, number % kCameras, frame);
  frame->has_pixel_format = frame->has_black_level_dn = frame->has_gain_per_dn = true;
  memcpy(frame->pixel_format, header->pixel_format, sizeof frame->pixel_format);
  frame->black_level_dn = header->black_level_dn;
  frame->gain_per_dn = header->gain_per_dn;
  frame->radiance_scale_count = header->radiance_scale_count;
  memcpy(frame->radiance_scale, header->radiance_scale, sizeof frame->radiance_scale);
  return photograph;
}

static bool is_forgotten(const struct collector* c, unsigned epoch) {
  return __atomic_load_n(&c->epoch, __ATOMIC_SEQ_CST) != epoch;
}

static void keep(struct collector* c, unsigned number, const struct hal_photograph* raw) {
  const struct photograph photograph = describe(c, number, &raw->header);
  if (!store_keep(c->store, &photograph)) return fail(c, store_fault(c->store));
  __atomic_fetch_add(&c->kept, 1, __ATOMIC_SEQ_CST);
  __atomic_fetch_add(&c->done, 1, __ATOMIC_SEQ_CST);
}

static void drop(struct collector* c, unsigned number, const struct hal_photograph* raw) {
  complain("lamella-rigd: shot %u, camera %u: dropped: %s", number / kCameras, number % kCameras,
           raw->error);
  c->dropped[number / kCameras] = true;
  __atomic_fetch_add(&c->done, 1, __ATOMIC_SEQ_CST);
}

static void collect(struct collector* c, unsigned epoch, unsigned number) {
  struct hal_photograph raw = {0};
  raw.bytes = store_room(c->store, &raw.capacity);
  const enum lam_status status =
      c->hal->read_photograph(c->hal->self, number / kCameras, number % kCameras, &raw);
  if (is_forgotten(c, epoch)) return;
  if (status == LAM_OK) {
    keep(c, number, &raw);
  } else if (status == LAM_DROPPED) {
    drop(c, number, &raw);
  } else {
    fail(c, raw.error);
  }
}

// One epoch after the other: everything of a burst, as far as it is offered.
static void* run(void* self) {
  struct collector* c = self;
  while (!__atomic_load_n(&c->stops, __ATOMIC_SEQ_CST)) {
    const unsigned epoch = __atomic_load_n(&c->epoch, __ATOMIC_SEQ_CST);
    __atomic_store_n(&c->idle_in, epoch, __ATOMIC_SEQ_CST);
    for (unsigned number = __atomic_load_n(&c->done, __ATOMIC_SEQ_CST);
         number < kCameras * __atomic_load_n(&c->offered, __ATOMIC_SEQ_CST) &&
         !__atomic_load_n(&c->failed, __ATOMIC_SEQ_CST) && !is_forgotten(c, epoch);
         number++) {
      collect(c, epoch, number);
      sem_post(&c->progress);
    }
    sem_post(&c->progress);
    sem_wait(&c->work);
  }
  return NULL;
}

// Every processor but the sequencer's, which shares the only one.
static void choose_processors(const struct rig* rig, pthread_attr_t* attributes) {
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  for (long cpu = 0; rig->board.given && cpu < sysconf(_SC_NPROCESSORS_ONLN); cpu++) {
    if (cpu != (long)rig->board.cpu) CPU_SET((size_t)cpu, &cpus);
  }
  if (CPU_COUNT(&cpus) > 0) pthread_attr_setaffinity_np(attributes, sizeof cpus, &cpus);
}

// Signals are the sequencer's; its scheduling is not inherited.
static int create(struct collector* c, const struct rig* rig) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_attr_t attributes;
  const struct sched_param normal = {0};
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kStackBytes);
  pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
  pthread_attr_setschedpolicy(&attributes, SCHED_OTHER);
  pthread_attr_setschedparam(&attributes, &normal);
  choose_processors(rig, &attributes);
  pthread_sigmask(SIG_BLOCK, &all, &before);
  const int failure = pthread_create(&c->thread, &attributes, run, c);
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  pthread_attr_destroy(&attributes);
  return failure;
}

enum lam_status collector_start(struct collector* c, struct hal* hal, struct store* store,
                                const struct rig* rig, const struct roll* roll) {
  c->hal = hal;
  c->store = store;
  c->roll = roll;
  if (sem_init(&c->work, 0, 0) != 0 || sem_init(&c->progress, 0, 0) != 0) return LAM_HARDWARE;
  c->runs = create(c, rig) == 0;
  return c->runs ? LAM_OK : LAM_HARDWARE;
}

static struct timespec in_us(clockid_t clock, double us) {
  struct timespec at;
  clock_gettime(clock, &at);
  const long long ns = at.tv_nsec + (long long)(us * 1e3);
  return (struct timespec){at.tv_sec + ns / 1000000000, ns % 1000000000};
}

bool collector_stop(struct collector* c) {
  if (!c->runs) return true;
  collector_forget(c);
  __atomic_store_n(&c->stops, true, __ATOMIC_SEQ_CST);
  sem_post(&c->work);
  const struct timespec end = in_us(CLOCK_REALTIME, kLongestStopUs);
  if (pthread_timedjoin_np(c->thread, NULL, &end) != 0) return false;
  c->runs = false;
  sem_destroy(&c->work);
  sem_destroy(&c->progress);
  return true;
}

// Nothing is offered before the thread can see the new epoch: it would read it in the old one.
void collector_forget(struct collector* c) {
  __atomic_store_n(&c->offered, 0, __ATOMIC_SEQ_CST);
  __atomic_fetch_add(&c->epoch, 1, __ATOMIC_SEQ_CST);
  sem_post(&c->work);
}

bool collector_is_idle(const struct collector* c) {
  return !c->runs || __atomic_load_n(&c->idle_in, __ATOMIC_SEQ_CST) ==
                         __atomic_load_n(&c->epoch, __ATOMIC_SEQ_CST);
}

void collector_begin(struct collector* c) {
  __atomic_store_n(&c->done, 0, __ATOMIC_SEQ_CST);
  __atomic_store_n(&c->kept, 0, __ATOMIC_SEQ_CST);
  __atomic_store_n(&c->failed, false, __ATOMIC_SEQ_CST);
  memset(c->dropped, 0, sizeof c->dropped);
}

void collector_offer(struct collector* c, unsigned shots) {
  __atomic_store_n(&c->offered, shots, __ATOMIC_SEQ_CST);
  sem_post(&c->work);
}

// False once the time is over.
static bool await_progress(struct collector* c, const struct timespec* end) {
  int failed;
  do {
    failed = sem_clockwait(&c->progress, CLOCK_MONOTONIC, end);
  } while (failed != 0 && errno == EINTR);
  return failed == 0;
}

void collector_wait(struct collector* c, double longest_us) {
  const struct timespec end = in_us(CLOCK_MONOTONIC, longest_us);
  await_progress(c, &end);
}

bool collector_wait_idle(struct collector* c, double longest_us) {
  const struct timespec end = in_us(CLOCK_MONOTONIC, longest_us);
  while (!collector_is_idle(c) && await_progress(c, &end)) continue;
  return collector_is_idle(c);
}

unsigned collector_done(const struct collector* c) {
  return __atomic_load_n(&c->done, __ATOMIC_SEQ_CST);
}

unsigned collector_kept(const struct collector* c) {
  return __atomic_load_n(&c->kept, __ATOMIC_SEQ_CST);
}

bool collector_has_failed(const struct collector* c) {
  return __atomic_load_n(&c->failed, __ATOMIC_SEQ_CST);
}
