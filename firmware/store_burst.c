#include "store_burst.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "store.h"
#include "store_record.h"

void burst_folder_name(uint64_t id, const char* suffix, char name[DISK_MAX_PATH]) {
  snprintf(name, DISK_MAX_PATH, "burst-%06llu%s", (unsigned long long)id, suffix);
}

void burst_path(const struct held_burst* burst, const char* file, char path[DISK_MAX_PATH]) {
  char folder[DISK_MAX_PATH];
  burst_folder_name(burst->id, burst->named_whole ? "" : ".partial", folder);
  snprintf(path, DISK_MAX_PATH, "%.36s/%.24s", folder, file);
}

void burst_frame_path(const struct held_burst* burst, uint32_t frame_id, const char* suffix,
                      char path[DISK_MAX_PATH]) {
  char file[24];
  snprintf(file, sizeof file, "frame-%02u.%.10s", (unsigned)(frame_id & 0xFF), suffix);
  burst_path(burst, file, path);
}

static int put_message(struct disk* disk, const char* path, const pb_msgdesc_t* fields,
                       const void* message) {
  uint8_t bytes[RECORD_MAX_BYTES];
  const size_t size = record_put(fields, message, bytes, sizeof bytes);
  return size == 0 ? EMSGSIZE : disk_write_whole(disk, path, bytes, size);
}

static bool get_message(const struct disk* disk, const char* path, const pb_msgdesc_t* fields,
                        void* message) {
  uint8_t bytes[RECORD_MAX_BYTES];
  const ssize_t size = disk_read(disk, path, bytes, sizeof bytes);
  return size > 0 && record_get(fields, message, bytes, (size_t)size) > 0;
}

static int sync_burst(struct disk* disk, const struct held_burst* burst) {
  char folder[DISK_MAX_PATH];
  burst_folder_name(burst->id, burst->named_whole ? "" : ".partial", folder);
  return disk_sync_folder(disk, folder);
}

int burst_make(struct disk* disk, const struct held_burst* burst, const uint8_t* calibration,
               size_t calibration_size) {
  char path[DISK_MAX_PATH];
  lamella_v1_BurstBegin begin = {.burst_id = burst->id,
                                 .begun_unix_us = burst->begun_unix_us,
                                 .frames_expected = burst->expected,
                                 .flashing_confirmed = burst->flashing_confirmed};
  memcpy(begin.subject, burst->subject, sizeof begin.subject);
  burst_folder_name(burst->id, ".partial", path);
  int failed = disk_make_folder(disk, path);
  if (failed == 0) failed = disk_sync_folder(disk, ".");
  burst_path(burst, "begin", path);
  if (failed == 0) failed = put_message(disk, path, lamella_v1_BurstBegin_fields, &begin);
  burst_path(burst, "calibration.json", path);
  if (failed == 0) failed = disk_write_whole(disk, path, calibration, calibration_size);
  return failed != 0 ? failed : sync_burst(disk, burst);
}

int burst_put_record(struct disk* disk, const struct held_burst* burst,
                     const lamella_v1_FrameOffer* offer) {
  char path[DISK_MAX_PATH];
  burst_frame_path(burst, offer->frame_id, "record", path);
  const int failed = put_message(disk, path, lamella_v1_FrameOffer_fields, offer);
  return failed != 0 ? failed : sync_burst(disk, burst);
}

int burst_put_frame(struct disk* disk, const struct held_burst* burst,
                    const lamella_v1_FrameOffer* offer, const uint8_t* bytes) {
  char path[DISK_MAX_PATH];
  burst_frame_path(burst, offer->frame_id, "raw", path);
  const int failed = disk_write_whole(disk, path, bytes, offer->size_bytes);
  return failed != 0 ? failed : burst_put_record(disk, burst, offer);
}

// Timing of any length, in records of a page each.
static int put_timing(struct disk* disk, const struct held_burst* burst,
                      const struct store_ending* ending) {
  static uint8_t bytes[STORE_MAX_TIMING_BYTES];
  static lamella_v1_TimingEdges page;
  char path[DISK_MAX_PATH];
  size_t size = 0;
  uint32_t first = 0;
  if (ending->timing == NULL) return 0;
  do {
    ending->timing(ending->context, first, &page);
    const size_t put =
        record_put(lamella_v1_TimingEdges_fields, &page, bytes + size, sizeof bytes - size);
    if (put == 0) return EMSGSIZE;
    size += put;
    first += page.edges_count;
  } while (page.edges_count > 0 && first < page.total_edges);
  burst_path(burst, "timing", path);
  return disk_write_whole(disk, path, bytes, size);
}

int burst_put_end(struct disk* disk, struct held_burst* burst, const struct store_ending* ending) {
  static lamella_v1_BurstEnd end;
  char path[DISK_MAX_PATH];
  end = (lamella_v1_BurstEnd){.burst_id = burst->id, .has_done = true, .done = ending->done};
  if (ending->why != NULL) snprintf(end.why, sizeof end.why, "%s", ending->why);
  for (uint32_t i = 0; i < STORE_MAX_PHOTOGRAPHS; i++) {
    if (burst->frames[i] != FRAME_NONE) end.frame_ids[end.frame_ids_count++] = i;
  }
  int failed = put_timing(disk, burst, ending);
  if (failed == 0) failed = sync_burst(disk, burst);  // never an end without its timing
  burst_path(burst, "end", path);
  if (failed == 0) failed = put_message(disk, path, lamella_v1_BurstEnd_fields, &end);
  if (failed == 0) failed = sync_burst(disk, burst);
  if (failed == 0 && ending->why == NULL) failed = burst_name_whole(disk, burst);
  if (failed == 0 && ending->why != NULL) burst_explain(burst, &end);
  return failed;
}

int burst_name_whole(struct disk* disk, struct held_burst* burst) {
  char partial[DISK_MAX_PATH], whole[DISK_MAX_PATH];
  burst_folder_name(burst->id, ".partial", partial);
  burst_folder_name(burst->id, "", whole);
  int failed = disk_rename(disk, partial, whole);
  if (failed == 0) burst->named_whole = true;
  if (failed == 0) failed = disk_sync_folder(disk, ".");
  if (failed == 0) burst->whole = true;
  return failed;
}

int burst_acknowledge(struct disk* disk, struct held_burst* burst, uint32_t frame_id) {
  char record[DISK_MAX_PATH], acked[DISK_MAX_PATH], raw[DISK_MAX_PATH];
  burst_frame_path(burst, frame_id, "record", record);
  burst_frame_path(burst, frame_id, "acked", acked);
  burst_frame_path(burst, frame_id, "raw", raw);
  const int64_t size = disk_size(disk, raw);
  int failed = disk_rename(disk, record, acked);
  if (failed == 0) failed = sync_burst(disk, burst);
  if (failed != 0) return failed;
  burst->frames[frame_id] = FRAME_ACKNOWLEDGED;
  burst->held--;
  burst->acknowledged++;
  burst->bytes -= size > 0 ? (uint64_t)size : 0;
  disk_remove(disk, raw);  // what stays is removed at the next start
  return 0;
}

struct clearing {
  struct disk* disk;
  const char* folder;
  int failed;
};

static bool clear_one(void* context, const char* name) {
  struct clearing* clearing = context;
  char path[DISK_MAX_PATH];
  snprintf(path, sizeof path, "%.36s/%.26s", clearing->folder, name);
  clearing->failed = disk_remove(clearing->disk, path);
  return clearing->failed == 0;
}

int burst_clear_folder(struct disk* disk, const char* folder) {
  struct clearing clearing = {.disk = disk, .folder = folder};
  disk_list(disk, folder, clear_one, &clearing);
  return clearing.failed != 0 ? clearing.failed : disk_remove_folder(disk, folder);
}

int burst_remove(struct disk* disk, const struct held_burst* burst) {
  char folder[DISK_MAX_PATH], gone[DISK_MAX_PATH];
  burst_folder_name(burst->id, burst->named_whole ? "" : ".partial", folder);
  burst_folder_name(burst->id, ".gone", gone);
  int failed = disk_rename(disk, folder, gone);
  if (failed == 0) failed = disk_sync_folder(disk, ".");
  return failed != 0 ? failed : burst_clear_folder(disk, gone);
}

bool burst_get_offer(const struct disk* disk, const struct held_burst* burst, uint32_t frame_id,
                     lamella_v1_FrameOffer* offer) {
  char path[DISK_MAX_PATH];
  burst_frame_path(burst, frame_id, "record", path);
  return get_message(disk, path, lamella_v1_FrameOffer_fields, offer) &&
         offer->burst_id == burst->id && offer->frame_id == frame_id;
}

bool burst_get_end(const struct disk* disk, const struct held_burst* burst,
                   lamella_v1_BurstEnd* end) {
  char path[DISK_MAX_PATH];
  burst_path(burst, "end", path);
  return get_message(disk, path, lamella_v1_BurstEnd_fields, end) && end->burst_id == burst->id;
}

// Leaves out the edges before `first_edge`.
static void cut_front(lamella_v1_TimingEdges* page, uint32_t first_edge) {
  const uint32_t cut = first_edge - page->first_edge;
  page->edges_count = (pb_size_t)(page->edges_count - cut);
  memmove(page->edges, page->edges + cut, page->edges_count * sizeof page->edges[0]);
  page->first_edge = first_edge;
}

bool burst_get_timing(const struct disk* disk, const struct held_burst* burst, uint32_t first_edge,
                      lamella_v1_TimingEdges* page) {
  static uint8_t bytes[STORE_MAX_TIMING_BYTES];
  char path[DISK_MAX_PATH];
  burst_path(burst, "timing", path);
  const ssize_t size = disk_read(disk, path, bytes, sizeof bytes);
  for (size_t at = 0; size > 0 && at < (size_t)size;) {
    const size_t got =
        record_get(lamella_v1_TimingEdges_fields, page, bytes + at, (size_t)size - at);
    if (got == 0) return false;
    at += got;
    const bool is_last = at == (size_t)size;
    if (first_edge < page->first_edge) return false;
    if (first_edge - page->first_edge < page->edges_count) {
      cut_front(page, first_edge);
      return true;
    }
    if (is_last) {  // none from there on, which is an answer too
      page->edges_count = 0;
      page->first_edge = first_edge;
      return true;
    }
  }
  return false;
}

void burst_explain(struct held_burst* burst, const lamella_v1_BurstEnd* end) {
  char damaged[40] = "";
  const uint32_t sound = burst->held + burst->acknowledged;
  if (burst->damaged > 0) {
    snprintf(damaged, sizeof damaged, ", %u damaged", (unsigned)burst->damaged);
  }
  if (burst->whole) {
    burst->why[0] = '\0';
  } else if (end != NULL && end->why[0] != '\0') {
    snprintf(burst->why, sizeof burst->why, "%.100s; %u of %u photographs are whole%s", end->why,
             (unsigned)sound, (unsigned)burst->expected, damaged);
  } else if (end != NULL) {
    snprintf(burst->why, sizeof burst->why,
             "ended well, but its disk lost some: %u of %u photographs are whole%s",
             (unsigned)sound, (unsigned)end->frame_ids_count, damaged);
  } else if (burst->expected == 0 && sound + burst->damaged > 0) {
    snprintf(burst->why, sizeof burst->why,
             "its first record is lost, so that nobody knows how many photographs it had: %u %s "
             "whole%s",
             (unsigned)sound, sound == 1 ? "is" : "are", damaged);
  } else if (sound == 0 && burst->damaged == 0) {
    snprintf(burst->why, sizeof burst->why,
             "power or the daemon was cut before the first photograph was on disk");
  } else {
    snprintf(burst->why, sizeof burst->why,
             "power or the daemon was cut before the burst's end was on disk: %u of %u "
             "photographs are whole%s",
             (unsigned)sound, (unsigned)burst->expected, damaged);
  }
}
