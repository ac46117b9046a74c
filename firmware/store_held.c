// What the rig's disk holds of bursts that are over, for hosts.
#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "complain.h"
#include "store_inside.h"

const struct held_burst* store_find_burst(const struct store* store, uint64_t burst_id) {
  for (size_t i = 0; i < store->burst_count; i++) {
    if (store->bursts[i].id == burst_id) return &store->bursts[i];
  }
  return NULL;
}

uint32_t store_bursts_held(struct store* store) {
  if (store->on_disk) return (uint32_t)store->burst_count;
  return store_held(store) > 0 && !store->is_open;
}

static void stop_reading(struct store* store) {
  if (store->reading >= 0) close(store->reading);
  store->reading = -1;
}

static enum lam_status forget_burst(struct store* store, struct held_burst* burst) {
  stop_reading(store);
  const int failed = burst_remove(&store->disk, burst);
  const size_t after = store->burst_count - (size_t)(burst - store->bursts) - 1;
  memmove(burst, burst + 1, after * sizeof *burst);
  store->burst_count--;
  // Nothing of it is asked for again, but somebody should hear that its room does not come back.
  if (failed != 0) complain("lamella-rigd: store: removal: %s", strerror(failed));
  return LAM_OK;
}

enum lam_status store_acknowledge(struct store* store, uint64_t burst_id, uint32_t frame_id) {
  struct held_burst* burst = (struct held_burst*)store_find_burst(store, burst_id);
  if (burst == NULL || frame_id >= STORE_MAX_PHOTOGRAPHS || burst->frames[frame_id] != FRAME_HELD) {
    return LAM_BAD_INPUT;
  }
  stop_reading(store);
  if (burst_acknowledge(&store->disk, burst, frame_id) != 0) return LAM_HARDWARE;
  return burst->held == 0 ? forget_burst(store, burst) : LAM_OK;
}

enum lam_status store_release(struct store* store, uint64_t burst_id) {
  struct held_burst* burst = (struct held_burst*)store_find_burst(store, burst_id);
  if (burst == NULL) return LAM_BAD_INPUT;
  return burst->held > 0 ? LAM_WRONG_STATE : forget_burst(store, burst);
}

static bool start_reading(struct store* store, const struct held_burst* burst, uint32_t frame_id) {
  if (store->reading >= 0 && store->reading_burst == burst->id &&
      store->reading_frame == frame_id) {
    return true;
  }
  char path[DISK_MAX_PATH];
  stop_reading(store);
  burst_frame_path(burst, frame_id, "raw", path);
  store->reading = disk_open_file(&store->disk, path);
  store->reading_burst = burst->id;
  store->reading_frame = frame_id;
  return store->reading >= 0;
}

size_t store_size(struct store* store, uint64_t burst_id, uint32_t frame_id) {
  const struct held_burst* burst = store_find_burst(store, burst_id);
  lamella_v1_FrameOffer offer;
  const bool held = burst != NULL && frame_id < STORE_MAX_PHOTOGRAPHS &&
                    burst->frames[frame_id] == FRAME_HELD &&
                    burst_get_offer(&store->disk, burst, frame_id, &offer);
  return held ? offer.size_bytes : 0;
}

size_t store_read(struct store* store, uint64_t burst_id, uint32_t frame_id, size_t offset,
                  uint8_t* to, size_t room) {
  const struct held_burst* burst = store_find_burst(store, burst_id);
  if (burst == NULL || frame_id >= STORE_MAX_PHOTOGRAPHS || burst->frames[frame_id] != FRAME_HELD ||
      !start_reading(store, burst, frame_id)) {
    return 0;
  }
  ssize_t got = 0;
  do {
    got = pread(store->reading, to, room, (off_t)offset);
  } while (got < 0 && errno == EINTR);
  return got > 0 ? (size_t)got : 0;
}
