// What an earlier end, good or bad, left on the disk: completed where everything is there,
// explained where it is not. Nothing that a host has not acknowledged is removed.
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "complain.h"
#include "store_inside.h"
#include "store_record.h"
#include "utf8.h"

static const char kCounter[] = "counter";

int store_count_burst(struct disk* disk, uint64_t burst_id) {
  uint8_t bytes[RECORD_OVERHEAD_BYTES + lamella_v1_BurstCounter_size];
  const lamella_v1_BurstCounter counter = {.last_burst_id = burst_id};
  const size_t size = record_put(lamella_v1_BurstCounter_fields, &counter, bytes, sizeof bytes);
  return disk_write_whole(disk, kCounter, bytes, size);
}

// The newest id ever given, as far as the counter knows. Where it is `spoilt` the time since 1970
// is larger than any count that a rig reaches.
static uint64_t last_counted(const struct disk* disk, bool* spoilt) {
  uint8_t bytes[64];
  lamella_v1_BurstCounter counter = {0};
  const ssize_t size = disk_read(disk, kCounter, bytes, sizeof bytes);
  *spoilt = false;
  if (size > 0 && record_get(lamella_v1_BurstCounter_fields, &counter, bytes, (size_t)size) > 0) {
    return counter.last_burst_id;
  }
  *spoilt = disk_has(disk, kCounter);
  return *spoilt ? (uint64_t)time(NULL) : 0;
}

// A record that was whole beside its place when power went.
static void finish_record(struct disk* disk, const struct held_burst* burst, uint32_t frame_id,
                          lamella_v1_FrameOffer* offer) {
  uint8_t bytes[RECORD_MAX_BYTES];
  char path[DISK_MAX_PATH];
  burst_frame_path(burst, frame_id, "record.tmp", path);
  const ssize_t size = disk_read(disk, path, bytes, sizeof bytes);
  const bool sound = size > 0 &&
                     record_get(lamella_v1_FrameOffer_fields, offer, bytes, (size_t)size) > 0 &&
                     offer->burst_id == burst->id && offer->frame_id == frame_id;
  if (sound) burst_put_record(disk, burst, offer);
}

// In a folder that is named whole everything was synced before it got its name: sizes are enough,
// and start-up need not read every byte. The host checks the CRC32C of what it fetches.
static bool is_sound(const struct disk* disk, const struct held_burst* burst,
                     const lamella_v1_FrameOffer* offer) {
  char path[DISK_MAX_PATH];
  burst_frame_path(burst, offer->frame_id, "raw", path);
  if (burst->named_whole) return disk_size(disk, path) == offer->size_bytes;
  uint64_t size = 0;
  uint32_t crc32c = 0;
  return disk_crc32c(disk, path, &size, &crc32c) && size == offer->size_bytes &&
         crc32c == offer->crc32c;
}

static void load_frame(struct disk* disk, struct held_burst* burst, uint32_t frame_id) {
  char acked[DISK_MAX_PATH], raw[DISK_MAX_PATH], record[DISK_MAX_PATH];
  lamella_v1_FrameOffer offer;
  burst_frame_path(burst, frame_id, "acked", acked);
  burst_frame_path(burst, frame_id, "raw", raw);
  burst_frame_path(burst, frame_id, "record", record);
  if (disk_has(disk, acked)) {
    burst->frames[frame_id] = FRAME_ACKNOWLEDGED;
    burst->acknowledged++;
    if (disk_has(disk, raw)) disk_remove(disk, raw);
    return;
  }
  if (!disk_has(disk, raw)) return;
  if (!disk_has(disk, record)) finish_record(disk, burst, frame_id, &offer);
  if (!disk_has(disk, record)) return;  // cut off before it was kept
  if (!burst_get_offer(disk, burst, frame_id, &offer) || !is_sound(disk, burst, &offer)) {
    burst->damaged++;
    return;
  }
  burst->frames[frame_id] = FRAME_HELD;
  burst->held++;
  burst->bytes += offer.size_bytes;
}

static void load_begin(const struct disk* disk, struct held_burst* burst) {
  uint8_t bytes[RECORD_OVERHEAD_BYTES + lamella_v1_BurstBegin_size];
  char path[DISK_MAX_PATH];
  lamella_v1_BurstBegin begin = {0};
  burst_path(burst, "begin", path);
  const ssize_t size = disk_read(disk, path, bytes, sizeof bytes);
  if (size <= 0 || record_get(lamella_v1_BurstBegin_fields, &begin, bytes, (size_t)size) == 0) {
    return;
  }
  burst->begun_unix_us = begin.begun_unix_us;
  burst->expected = begin.frames_expected;
  burst->flashing_confirmed = begin.flashing_confirmed;
  // One that is not UTF-8 would keep a host from reading of any burst.
  if (utf8_is_valid(begin.subject)) memcpy(burst->subject, begin.subject, sizeof begin.subject);
}

static bool is_all_there(const struct held_burst* burst, const lamella_v1_BurstEnd* end) {
  for (pb_size_t i = 0; i < end->frame_ids_count; i++) {
    const uint32_t id = end->frame_ids[i];
    if (id >= STORE_MAX_PHOTOGRAPHS || burst->frames[id] == FRAME_NONE) return false;
  }
  return end->why[0] == '\0';
}

static void say(const struct held_burst* burst, bool completed) {
  if (burst->whole && !completed) return;
  complain("lamella-rigd: store: burst %" PRIu64 ": %s", burst->id,
           completed ? "whole, only its name was missing: completed" : burst->why);
}

// 0 with `burst->id` 0: there was nothing left of it.
static int load_burst(struct disk* disk, struct held_burst* burst) {
  static lamella_v1_BurstEnd end;
  bool completed = false;
  int failed = 0;
  load_begin(disk, burst);
  for (uint32_t i = 0; i < STORE_MAX_PHOTOGRAPHS; i++) load_frame(disk, burst, i);
  const bool ended = burst_get_end(disk, burst, &end);
  const bool all = ended && is_all_there(burst, &end);
  burst->whole = all && burst->named_whole;
  if (all && !burst->named_whole) {
    failed = burst_name_whole(disk, burst);
    completed = failed == 0;
  }
  burst_explain(burst, ended ? &end : NULL);
  say(burst, completed);
  // Its last photograph was acknowledged. What cannot be read was not: somebody is to hear of that.
  const bool is_done = burst->held == 0 && burst->acknowledged > 0 && burst->damaged == 0;
  if (failed != 0 || !is_done) return failed;
  failed = burst_remove(disk, burst);
  burst->id = 0;
  return failed;
}

struct folders {
  struct held_burst* bursts;
  size_t count;
  uint64_t newest, gone[STORE_MAX_BURSTS];
  size_t gone_count;
};

// The number in a burst's name, and what is behind it; 0: nothing of ours.
static uint64_t read_name(const char* name, const char** suffix) {
  char* end = NULL;
  char again[DISK_MAX_PATH];
  if (strncmp(name, "burst-", 6) != 0 || name[6] < '0' || name[6] > '9') return 0;
  const uint64_t id = strtoull(name + 6, &end, 10);
  burst_folder_name(id, end, again);
  *suffix = end;
  return strcmp(again, name) == 0 ? id : 0;
}

struct stranger {
  const struct disk* disk;
  char name[DISK_MAX_PATH];  // "": none was met
  bool is_session;
};

static bool has_file(const struct disk* disk, const char* folder, const char* file) {
  char path[DISK_MAX_PATH];
  snprintf(path, sizeof path, "%.36s/%.24s", folder, file);
  return disk_has(disk, path);
}

struct content {
  bool any, ours;
};

static bool know(void* context, const char* name) {
  static const char* const kNames[] = {"begin", "calibration.json", "frame-", "timing", "end"};
  struct content* content = context;
  content->any = true;
  for (size_t i = 0; i < sizeof kNames / sizeof kNames[0]; i++) {
    content->ours = content->ours || strncmp(name, kNames[i], strlen(kNames[i])) == 0;
  }
  return !content->ours;
}

// A disk may have lost anything of a burst, but nothing else gets into its folder.
static bool is_of_a_rig(const struct disk* disk, const char* folder) {
  struct content content = {0};
  disk_list(disk, folder, know, &content);
  return content.ours || (!content.any && disk_is_folder(disk, folder));
}

static bool meet(void* context, const char* name) {
  struct stranger* stranger = context;
  const struct disk* disk = stranger->disk;
  const char* suffix = "";
  if (read_name(name, &suffix) == 0) return true;
  stranger->is_session = has_file(disk, name, "session.json");
  const bool is_whole = *suffix == '\0';
  if (!stranger->is_session && (!is_whole || is_of_a_rig(disk, name))) return true;
  snprintf(stranger->name, sizeof stranger->name, "%s", name);
  return false;
}

bool store_is_a_rigs(const struct disk* disk, char why[160]) {
  struct stranger stranger = {.disk = disk};
  disk_list(disk, ".", meet, &stranger);
  if (stranger.name[0] == '\0') return true;
  snprintf(why, 160, "%.40s %s", stranger.name,
           stranger.is_session
               ? "is a host's session, not a burst that a rig keeps: give the store a folder of "
                 "its own"
               : "has nothing that a rig wrote: move it elsewhere, or give the store a folder of "
                 "its own");
  return false;
}

static bool note_folder(void* context, const char* name) {
  struct folders* folders = context;
  const char* suffix = "";
  const uint64_t id = read_name(name, &suffix);
  if (id == 0) return true;
  if (id > folders->newest) folders->newest = id;
  const bool whole = *suffix == '\0';
  if (strcmp(suffix, ".gone") == 0 && folders->gone_count < STORE_MAX_BURSTS) {
    folders->gone[folders->gone_count++] = id;
  } else if ((whole || strcmp(suffix, ".partial") == 0) && folders->count < STORE_MAX_BURSTS) {
    folders->bursts[folders->count++] = (struct held_burst){.id = id, .named_whole = whole};
  }
  return true;
}

static int by_id(const void* a, const void* b) {
  const struct held_burst *left = a, *right = b;
  return left->id < right->id ? -1 : left->id > right->id;
}

int store_recover(struct store* store) {
  struct folders folders = {.bursts = store->bursts};
  disk_list(&store->disk, ".", note_folder, &folders);
  int failed = 0;
  for (size_t i = 0; i < folders.gone_count && failed == 0; i++) {
    char name[DISK_MAX_PATH];
    burst_folder_name(folders.gone[i], ".gone", name);
    failed = burst_clear_folder(&store->disk, name);
  }
  qsort(store->bursts, folders.count, sizeof store->bursts[0], by_id);
  store->burst_count = 0;
  for (size_t i = 0; i < folders.count && failed == 0; i++) {
    failed = load_burst(&store->disk, &store->bursts[i]);
    if (store->bursts[i].id != 0) store->bursts[store->burst_count++] = store->bursts[i];
  }
  bool spoilt = false;
  const uint64_t counted = last_counted(&store->disk, &spoilt);
  store->last_burst_id = counted > folders.newest ? counted : folders.newest;
  if (spoilt) {
    complain("lamella-rigd: store: '%s' is spoilt: the next burst is number %" PRIu64
             ", which no burst here had",
             kCounter, store->last_burst_id + 1);
  }
  return failed;
}
