// The thread that takes photographs from memory to the disk, and the ring of memory before it.
#define _GNU_SOURCE
#include <errno.h>
#include <sched.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "store_inside.h"

enum { kStackBytes = 256 << 10 };

static void offer_of(const struct store* store, const struct photograph* photograph,
                     lamella_v1_FrameOffer* offer) {
  *offer = (lamella_v1_FrameOffer){.burst_id = store->current.id,
                                   .frame_id = photograph->frame_id,
                                   .has_frame = true,
                                   .frame = photograph->frame,
                                   .width = photograph->width,
                                   .height = photograph->height,
                                   .size_bytes = (uint32_t)photograph->size,
                                   .crc32c = photograph->crc32c,
                                   .marked = photograph->marked};
}

// With the lock held, which is let go while the disk works.
static void write_next(struct store* store) {
  struct photograph* next = &store->photographs[store->written];
  lamella_v1_FrameOffer offer;
  offer_of(store, next, &offer);
  const uint8_t* bytes = next->bytes;
  store->writing = true;
  pthread_mutex_unlock(&store->lock);
  const int failed = burst_put_frame(&store->disk, &store->current, &offer, bytes);
  pthread_mutex_lock(&store->lock);
  store->writing = false;
  if (failed != 0) {
    store_fail(store, "the rig's disk does not take the photographs", failed);
  } else {
    next->bytes = NULL;
    store->current.frames[next->frame_id] = FRAME_HELD;
    store->current.held++;
    store->current.bytes += next->size;
    store->written++;
  }
  pthread_cond_broadcast(&store->moved);
}

static void* write_on(void* context) {
  struct store* store = context;
  pthread_mutex_lock(&store->lock);
  while (!store->stopping) {
    if (store->written < store->count && !store_has_failed(store)) {
      write_next(store);
    } else {
      pthread_cond_wait(&store->moved, &store->lock);
    }
  }
  pthread_mutex_unlock(&store->lock);
  return NULL;
}

static void keep_off(pthread_attr_t* attributes, int cpu) {
  cpu_set_t cpus;
  if (cpu < 0 || sysconf(_SC_NPROCESSORS_ONLN) < 2) return;  // there is no other
  if (sched_getaffinity(0, sizeof cpus, &cpus) != 0) return;
  for (int i = 0; CPU_COUNT(&cpus) < 2 && i < CPU_SETSIZE; i++) CPU_SET(i, &cpus);
  CPU_CLR(cpu, &cpus);
  pthread_attr_setaffinity_np(attributes, sizeof cpus, &cpus);
}

// Whoever asks may be the sequencer, at real-time priority and on a processor of its own.
int writer_start(struct store* store) {
  if (store->writer_runs) return 0;
  pthread_attr_t attributes;
  const struct sched_param normal = {0};
  int failed = pthread_attr_init(&attributes);
  if (failed != 0) return failed;
  pthread_attr_setstacksize(&attributes, kStackBytes);
  pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
  pthread_attr_setschedpolicy(&attributes, SCHED_OTHER);
  pthread_attr_setschedparam(&attributes, &normal);
  keep_off(&attributes, store->avoid_cpu);
  store->stopping = false;
  failed = pthread_create(&store->writer, &attributes, write_on, store);
  pthread_attr_destroy(&attributes);
  store->writer_runs = failed == 0;
  return failed;
}

void writer_stop(struct store* store) {
  if (!store->writer_runs) return;
  pthread_mutex_lock(&store->lock);
  store->stopping = true;
  pthread_cond_broadcast(&store->moved);
  pthread_mutex_unlock(&store->lock);
  pthread_join(store->writer, NULL);
  store->writer_runs = false;
}

void writer_drop_queue(struct store* store) {
  pthread_mutex_lock(&store->lock);
  store->count = store->written + (store->writing ? 1 : 0);
  pthread_mutex_unlock(&store->lock);
}

// Photographs leave in the order in which they came, so what is in memory is one piece of the ring.
// A photograph is never split over its end.
uint8_t* writer_room(struct store* store, size_t* room) {
  while (!store_has_failed(store) && store->count < STORE_MAX_PHOTOGRAPHS) {
    if (store->written == store->count) {
      store->used = 0;
      *room = store->capacity;
      return store->block;
    }
    const size_t tail = (size_t)(store->photographs[store->written].bytes - store->block);
    const size_t behind = store->used > tail ? store->capacity - store->used : tail - store->used;
    if (store->used > tail && behind < store->wanted && tail >= store->wanted) {
      store->used = 0;
      *room = tail;
      return store->block;
    }
    if (behind >= store->wanted) {
      *room = behind;
      return store->block + store->used;
    }
    pthread_cond_wait(&store->moved, &store->lock);
  }
  *room = 0;
  return store->block;
}

bool store_is_written(struct store* store, unsigned wait_ms) {
  if (!store->on_disk) return true;
  struct timespec end;
  clock_gettime(CLOCK_MONOTONIC, &end);
  end.tv_sec += wait_ms / 1000;
  end.tv_nsec += (long)(wait_ms % 1000) * 1000000;
  if (end.tv_nsec >= 1000000000) {
    end.tv_nsec -= 1000000000;
    end.tv_sec++;
  }
  pthread_mutex_lock(&store->lock);
  bool busy = true;
  for (int waited = 0; waited == 0;) {
    busy = store->writing || (store->written < store->count && !store_has_failed(store));
    if (!busy) break;
    waited = pthread_cond_timedwait(&store->moved, &store->lock, &end);
  }
  pthread_mutex_unlock(&store->lock);
  return !busy;
}
