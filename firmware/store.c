#include "store.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "store_inside.h"

// Beside the photographs: records, timing, and what a file system keeps for itself.
static const double kSpareBytes = 4 << 20;

void store_init(struct store* store, uint8_t* block, size_t capacity) {
  memset(store, 0, sizeof *store);
  store->block = block;
  store->capacity = capacity;
  store->disk.root = store->reading = store->avoid_cpu = -1;
  pthread_mutex_init(&store->lock, NULL);
  pthread_condattr_t attributes;
  pthread_condattr_init(&attributes);
  pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
  pthread_cond_init(&store->moved, &attributes);
  pthread_condattr_destroy(&attributes);
}

enum lam_status store_open(struct store* store, const char* folder, const uint8_t* calibration,
                           size_t calibration_size, char* why, size_t why_size) {
  int failed = disk_open(&store->disk, folder);
  if (failed == EWOULDBLOCK) {
    snprintf(why, why_size, "--store %s: another daemon keeps its photographs there", folder);
    return LAM_BAD_INPUT;
  }
  if (failed != 0) {
    snprintf(why, why_size, "--store %s: %s", folder, disk_explain(failed));
    return LAM_BAD_INPUT;
  }
  char stranger[160];
  if (!store_is_a_rigs(&store->disk, stranger)) {
    snprintf(why, why_size, "--store %s: %s", folder, stranger);
    disk_close(&store->disk);
    return LAM_BAD_INPUT;
  }
  store->calibration = calibration;
  store->calibration_size = calibration_size;
  failed = store_recover(store);
  store->on_disk = failed == 0;
  if (failed == 0) return LAM_OK;
  snprintf(why, why_size, "--store %s: recovery: %s: %s", folder, store->disk.failed,
           disk_explain(failed));
  disk_close(&store->disk);
  return LAM_HARDWARE;
}

void store_close(struct store* store) {
  if (!store->on_disk) return;
  if (store->is_open) {
    const struct store_ending ending = {.why = "the daemon was stopped"};
    store_end(store, &ending);
  }
  writer_stop(store);
  if (store->reading >= 0) close(store->reading);
  disk_close(&store->disk);
  store->on_disk = false;
}

void store_fail(struct store* store, const char* what, int error) {
  if (store_has_failed(store)) return;
  snprintf(store->fault, sizeof store->fault, "%s%s%s", what, error != 0 ? ": " : "",
           error != 0 ? disk_explain(error) : "");
  __atomic_store_n(&store->failed, true, __ATOMIC_RELEASE);
}

static void forget(struct store* store) {
  store->used = store->count = store->written = 0;
  store->place = NULL;
  __atomic_store_n(&store->failed, false, __ATOMIC_RELEASE);
}

static int64_t unix_now_us(void) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}

double store_needed_bytes(double frames, double frame_bytes) {
  return frames * frame_bytes + kSpareBytes;
}

static enum lam_status begin_on_disk(struct store* store, const struct store_order* order,
                                     char* why, size_t why_size) {
  const double needed = store_needed_bytes(order->frames, order->frame_bytes);
  const double free_bytes = (double)disk_free_bytes(&store->disk);
  if (free_bytes < needed && !disk_is_read_only(&store->disk)) {
    snprintf(why, why_size, "the rig's disk has %.2f MB free and a burst needs %.2f MB: %s",
             free_bytes * 1e-6, needed * 1e-6,
             store->burst_count > 0 ? "fetch what it holds (lamella rig sync)"
                                    : "no burst takes that room: make some on it");
    return LAM_STORE_FULL;
  }
  if (store->burst_count == STORE_MAX_BURSTS) {
    snprintf(why, why_size, "the rig holds %d bursts: fetch them (lamella rig sync)",
             STORE_MAX_BURSTS);
    return LAM_STORE_FULL;
  }
  const uint64_t id = store->last_burst_id + 1;
  store->current.id = id;
  store->current.begun_unix_us = unix_now_us();
  int failed = store_count_burst(&store->disk, id);
  if (failed == 0) store->last_burst_id = id;
  if (failed == 0) {
    failed = burst_make(&store->disk, &store->current, store->calibration, store->calibration_size);
  }
  if (failed == 0) failed = writer_start(store);
  if (failed == 0) return LAM_OK;
  snprintf(why, why_size, "a burst cannot be begun on the rig's disk: %s", disk_explain(failed));
  return failed == ENOSPC || failed == EDQUOT ? LAM_STORE_FULL : LAM_HARDWARE;
}

enum lam_status store_begin(struct store* store, const struct store_order* order,
                            uint64_t* burst_id, char* why, size_t why_size) {
  if (!store->on_disk && store_held(store) > 0 && !order->discard_held) {
    snprintf(why, why_size,
             "photographs of the last burst are held: take them (lamella capture --held), or give "
             "them up (--discard-held)");
    return LAM_WRONG_STATE;
  }
  pthread_mutex_lock(&store->lock);
  forget(store);
  store->wanted =
      order->frame_bytes < (double)store->capacity ? (size_t)order->frame_bytes : store->capacity;
  store->current = (struct held_burst){.expected = order->frames,
                                       .flashing_confirmed = order->flashing_confirmed};
  if (order->subject != NULL) {
    snprintf(store->current.subject, sizeof store->current.subject, "%s", order->subject);
  }
  pthread_mutex_unlock(&store->lock);
  enum lam_status status = LAM_OK;
  if (store->on_disk) {
    status = begin_on_disk(store, order, why, why_size);
  } else {
    store->last_burst_id++;
  }
  store->is_open = status == LAM_OK;
  if (store->is_open) *burst_id = store->last_burst_id;
  return status;
}

// With the lock held.
static void find_room(struct store* store) {
  if (store->on_disk) {
    store->place = writer_room(store, &store->place_room);
  } else {
    store->place = store->block + store->used;
    store->place_room = store->count < STORE_MAX_PHOTOGRAPHS ? store->capacity - store->used : 0;
  }
}

bool store_has_room(struct store* store, uint32_t frames, double frame_bytes) {
  if (!store->on_disk) return true;
  pthread_mutex_lock(&store->lock);
  const size_t queued = store->count - store->written;
  pthread_mutex_unlock(&store->lock);
  return (double)disk_free_bytes(&store->disk) >=
         store_needed_bytes((double)(frames + queued), frame_bytes);
}

uint8_t* store_room(struct store* store, size_t* room) {
  pthread_mutex_lock(&store->lock);
  find_room(store);
  *room = store->place_room;
  pthread_mutex_unlock(&store->lock);
  return store->place;
}

// With the lock held.
static bool fits(struct store* store, const struct photograph* photograph, size_t room) {
  if (store_has_failed(store)) return false;
  if (photograph->size > room) {
    store_fail(store, "the store is full: raise store.capacity_bytes in the rig file", 0);
  } else if (store->on_disk && photograph->frame_id >= STORE_MAX_PHOTOGRAPHS) {
    store_fail(store, "a burst of more photographs than the store keeps", 0);
  }
  return !store_has_failed(store);
}

bool store_keep(struct store* store, const struct photograph* photograph) {
  pthread_mutex_lock(&store->lock);
  if (store->place == NULL) find_room(store);
  const uint8_t* bytes = store->place;
  const bool keeps = fits(store, photograph, store->place_room);
  store->place = NULL;  // the ring may have moved on since it was given, but not into it
  if (keeps) {
    struct photograph* kept = &store->photographs[store->count++];
    *kept = *photograph;
    kept->bytes = bytes;
    kept->acknowledged = false;
    store->used = (size_t)(bytes - store->block) + photograph->size;
    if (photograph->size > store->wanted) store->wanted = photograph->size;
    pthread_cond_broadcast(&store->moved);
  }
  pthread_mutex_unlock(&store->lock);
  return keeps;
}

static void note_shot(lamella_v1_Frame* frame, int replaced_by) {
  frame->has_replaced_by = replaced_by >= 0;
  frame->replaced_by = replaced_by >= 0 ? (uint32_t)replaced_by : 0;
}

static void mark_on_disk(struct store* store, uint32_t frame_id, bool bad, int replaced_by) {
  lamella_v1_FrameOffer offer;
  if (!burst_get_offer(&store->disk, &store->current, frame_id, &offer)) return;  // dropped
  offer.marked = bad;
  note_shot(&offer.frame, replaced_by);
  const int failed = burst_put_record(&store->disk, &store->current, &offer);
  if (failed == 0) return;
  pthread_mutex_lock(&store->lock);
  store_fail(store, "a photograph cannot be marked on the rig's disk", failed);
  pthread_mutex_unlock(&store->lock);
}

void store_mark(struct store* store, uint32_t frame_id, bool bad, int replaced_by) {
  if (store->on_disk) {
    mark_on_disk(store, frame_id, bad, replaced_by);
    return;
  }
  struct photograph* photograph = store_find(store, frame_id);
  if (photograph == NULL) return;  // dropped
  photograph->marked = bad;
  note_shot(&photograph->frame, replaced_by);
}

static enum lam_status end_on_disk(struct store* store, const struct store_ending* ending) {
  if (ending->why != NULL) writer_drop_queue(store);
  while (!store_is_written(store, 1000)) continue;
  if (store_has_failed(store) && ending->why == NULL) return LAM_STORE_FULL;
  const int failed = burst_put_end(&store->disk, &store->current, ending);
  if (failed != 0 && ending->why == NULL) {
    pthread_mutex_lock(&store->lock);
    store_fail(store, "the burst's end cannot be written to the rig's disk", failed);
    pthread_mutex_unlock(&store->lock);
    return LAM_STORE_FULL;
  }
  if (failed != 0) {  // the disk will not even take the reason: say it as long as we run
    const lamella_v1_BurstEnd* none = NULL;
    burst_explain(&store->current, none);
    snprintf(store->current.why, sizeof store->current.why,
             "%.100s; %u of %u photographs are whole", ending->why, (unsigned)store->current.held,
             (unsigned)store->current.expected);
  }
  store->bursts[store->burst_count++] = store->current;
  return LAM_OK;
}

enum lam_status store_end(struct store* store, const struct store_ending* ending) {
  if (!store->is_open) return LAM_OK;
  enum lam_status status = LAM_OK;
  if (store->on_disk) {
    status = end_on_disk(store, ending);
  } else if (ending->why != NULL) {
    pthread_mutex_lock(&store->lock);
    store->used = store->count = 0;
    pthread_mutex_unlock(&store->lock);
  }
  store->is_open = status != LAM_OK;
  return status;
}

const char* store_fault(const struct store* store) {
  return store_has_failed(store) ? store->fault : "";
}

struct photograph* store_find(struct store* store, uint32_t frame_id) {
  for (size_t i = 0; i < store->count; i++) {
    struct photograph* photograph = &store->photographs[i];
    if (photograph->frame_id == frame_id && !photograph->acknowledged) return photograph;
  }
  return NULL;
}

size_t store_held(struct store* store) {
  size_t held = 0;
  pthread_mutex_lock(&store->lock);
  if (store->on_disk) {
    const struct held_burst* newest = store_find_burst(store, store->last_burst_id);
    held = store->is_open ? store->current.held : newest != NULL ? newest->held : 0;
  } else {
    for (size_t i = 0; i < store->count; i++) held += !store->photographs[i].acknowledged;
  }
  pthread_mutex_unlock(&store->lock);
  return held;
}
